from .go_to_goal import GoToGoal as GoToGoal
