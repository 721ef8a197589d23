"""Floors as relational facts, as kLog takes them: fact files, graphs, kernels, classifiers (thesis, chapter 6)."""
