"""Forms made of components' own fields."""
