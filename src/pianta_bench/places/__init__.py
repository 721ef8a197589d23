"""Tables 5.2 to 5.4 and 6.1: what each room is for."""
