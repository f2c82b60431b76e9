"""Pictures and films of the world; what can be asked for is known without loading OpenGL."""

CAMERAS = ("front", "close", "above")

#: Software OpenGL draws no larger pictures [pixels].
LARGEST_SIDE = 4096

#: No film has more pictures a second: that is what the physics step gives.
LARGEST_FPS = 100
