"""Bottom-up saliency on a sphere around the head: feature maps of pictures, the sphere, what it holds of percepts."""
