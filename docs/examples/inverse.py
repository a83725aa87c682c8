"""Find the stroke that gives the ball a velocity and a spin."""

from billiard_shot import invert_strike, Scene

stroke, residual = invert_strike(Scene.load('pool'), velocity=(1, 0, 0), spin=(0, 20, 0))
print(stroke.offsets, residual)
