"""The scale of a plan: every piece of evidence with its error, combined to metres per pixel with an interval."""
