"""Time methods, one a file, and what they share: the stage equation, Newton's method, linear solvers."""
