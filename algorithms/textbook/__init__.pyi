from .ekf_slam import TextbookEkfSlam as TextbookEkfSlam
from .fast_slam import TextbookFastSlam as TextbookFastSlam
from .monte_carlo import TextbookMonteCarlo as TextbookMonteCarlo
