"""The faults of lines that are not TOML, and what to write in their place."""

from __future__ import annotations

import re

__all__ = ["plain_problem", "toml_problem"]

_ANYTHING = "write KEY = VALUE, [TABLE] or [[LIST]]"
_REMEDIES = (
    ("Invalid value", "write a number, a 'text', true, false, a [list] or a { table }"),
    ("Expected '=' after a key", "write KEY = VALUE"),
    ("Expected newline", "write one value, and nothing but a # comment behind it"),
    ("Expected ']'", "close the header: [TABLE], or [[LIST]] for an item of a list"),
    ("Expected ", "close the text with the quote that it begins with"),
    ("Unterminated string", "close the text with the quote that it begins with"),
    ("Found invalid character", "close the text on the line that it begins on"),
    ("Illegal character", "close the text on the line that it begins on"),
    ("Unescaped", "write two backslashes for one, or 'single quotes' around the text"),
    ("Unclosed array", "separate the items by commas, and close the list with ]"),
    ("Unclosed inline table", "separate the pairs by commas, and close the table with }"),
    ("Invalid initial character for a key", "write a key of letters, digits, '_' and '-', or \"any text in quotes\""),
    ("Cannot mutate immutable namespace", "put it into the { braces } of the table that is there already"),
)
# What word processors put in place of a quote, where a value begins; and a comma in a pair of a table, as of a decimal.
_CURLY = re.compile(
    "[=\\[,{]\\s*[\N{LEFT DOUBLE QUOTATION MARK}\N{RIGHT DOUBLE QUOTATION MARK}"
    "\N{DOUBLE LOW-9 QUOTATION MARK}\N{LEFT SINGLE QUOTATION MARK}\N{RIGHT SINGLE QUOTATION MARK}]"
)
_COMMA = re.compile(r"=\s*(-?\d+),(\d+)")


def toml_problem(error: Exception, statement: str) -> str:
    """What is wrong with a statement of TOML, by the error of its reader, and what to do."""
    text = str(error)
    if isinstance(error, RecursionError):
        return "not valid TOML that can be read: too many tables or lists inside one another; write fewer"
    if twice := re.match(r"Cannot declare \((.*?),?\) twice", text):
        name = ".".join(part.strip(" '\"") for part in twice[1].split(","))
        return f"the table [{name}] stands in this file already; put what is here under the first one"
    if text.startswith(("Cannot overwrite a value", "Duplicate inline table key")):
        return "this key has a value already; leave one of the two out"
    column = re.search(r", column (\d+)\)", text)
    plain = re.sub(r" \(at .*?\)", "", text)
    remedy = next((remedy for begin, remedy in _REMEDIES if plain.startswith(begin)), _ANYTHING)
    if _CURLY.search(statement):
        remedy = 'write straight quotes around a text: "text"'
    elif comma := _COMMA.search(statement):
        remedy += f"; a decimal point is a dot: {comma[1]}.{comma[2]}"
    return f"not valid TOML: {plain}" + (f" (column {column[1]})" if column else "") + f"; {remedy}"


def plain_problem() -> str:
    """The message for a line whose fault is not known further."""
    return f"not valid TOML; {_ANYTHING}"
