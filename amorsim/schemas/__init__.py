"""JSON Schemas (draft 2020-12) of the files that users write: scenarios, studies, rubrics.

An editor with a schema completes keys, shows what they mean, and underlines mistakes. A schema refuses only what the
reader refuses. What needs more than one place of a file, a map or a model's file (names that must differ, starts in
walls, fields of a model that is not registered) the reader alone can know.
"""

from amorsim.schemas.schemas import KINDS, make_schema

__all__ = ["KINDS", "make_schema"]
