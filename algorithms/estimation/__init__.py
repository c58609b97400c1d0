"""Parts that several estimators share: models, systematic errors, graphs of poses, relocalization."""
