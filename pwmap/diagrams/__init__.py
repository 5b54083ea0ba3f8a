"""Branches and special points, their graph, tables and files: of both packages."""
