"""Extension of griffe: the comment beside a field, which holds its unit or shape, is its documentation."""

import ast
import re
from pathlib import Path
from typing import Any

import griffe


class Units(griffe.Extension):
    """Takes `f_max: Scalar  # N` for documentation."""

    def on_attribute_instance(
        self, *, node: ast.AST | griffe.ObjectNode, attr: griffe.Attribute, **kept: Any
    ) -> None:
        """Called for each attribute of a module or class."""
        if attr.docstring or not isinstance(node, ast.AST) or not isinstance(attr.parent, griffe.Class):
            return
        lines = attr.parent.module.lines_collection[Path(str(attr.filepath))]
        if beside := re.search(r"  # (.+)", lines[(attr.endlineno or attr.lineno or 1) - 1]):
            attr.docstring = griffe.Docstring(beside[1], parent=attr)
