from .review_api import ReviewApi as ReviewApi
