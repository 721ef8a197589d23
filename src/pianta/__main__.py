"""`python -m pianta`."""

from pianta.cli import main

main()
