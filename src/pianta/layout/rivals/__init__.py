"""Other ways to find rooms, from the survey of Bormann et al. (ICRA 2016): a grid map in, a label image out."""
