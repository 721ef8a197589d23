"""The default method: a network's evidence and narrow passages, one partition into rooms (thesis, chapter 9)."""
