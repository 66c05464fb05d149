"""How methods are compared: protocols, floors and the ceiling of the representation."""
