"""Balance shafts: unbalanced shafts geared to a crank that turns at constant speed."""
