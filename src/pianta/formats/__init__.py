"""Readers and writers, one file per file format."""
