"""Where `balance` finds the function that reads linkages."""

from kinematics.loading.model_gallery import load as load
