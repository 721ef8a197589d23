"""GridMap to label image: rival ways of finding rooms, from the survey of Bormann et al. (ICRA 2016)."""
