"""A sea of phytoplankton, copepods and krill under a sun that rises and sets: the world file, its policies, and a sense of its own."""
