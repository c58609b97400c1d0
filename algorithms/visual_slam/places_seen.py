"""Recognises places by their appearance: bags of words over the features of keyframes."""

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

WORDS, NOVEL = 1024, 60
"""Maximum number of words, and the number of different bits from all words at which a feature is a new one."""


class PlacesSeen:
    """Appearances of keyframes, by how often each visual word occurs in them.

    The words are features of the robot's own pictures, so no vocabulary has to be learnt before.

    References:
        Sivic, Zisserman, Video Google, ICCV 2003, equation 1: weights of words. Galvez-Lopez, Tardos, Bags of Binary
        Words for Fast Place Recognition in Image Sequences, IEEE T-RO 28(5), 2012: words of binary features. Angeli,
        Filliat, Doncieux, Meyer, Fast and Incremental Method for Loop-Closure Detection Using Bags of Visual Words,
        IEEE T-RO 24(5), 2008: words that are learnt on the way.
    """

    def __init__(self) -> None:
        """Start without words."""
        self._words = np.zeros((0, 32), dtype=np.uint8)
        self._bags = np.zeros((64, WORDS), dtype=np.float32)
        self._frequent = np.zeros(WORDS, dtype=np.float32)
        self._number = 0
        self._matcher = cv2.BFMatcher(cv2.NORM_HAMMING)

    def add(self, descriptors: NDArray[np.uint64]) -> None:
        """Add the features of a keyframe, shape (n, 4); it has the next number."""
        if self._number == len(self._bags):
            self._bags = np.concatenate([self._bags, np.zeros_like(self._bags)])
        bag = self._bag(descriptors.view(np.uint8))
        self._frequent += bag > 0.0
        self._bags[self._number] = bag / max(float(np.linalg.norm(bag)), 1e-9)
        self._number += 1

    def likeness(self, number: int, others: NDArray[np.intp]) -> Array:
        """Return how alike a keyframe and some others are, shape (k,)."""
        rarity = np.log((self._number + 1.0) / (self._frequent + 1.0)).astype(np.float32)
        return np.asarray(self._bags[others] @ (self._bags[number] * rarity), dtype=float)

    def _bag(self, features: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Return how often each word occurs, shape (WORDS,), the square root of each; unlike features are new words."""
        nearest = self._matcher.match(features, self._words) if len(self._words) and len(features) else []
        bits = np.array([each.distance for each in nearest] or [np.inf] * len(features))
        words = np.array([each.trainIdx for each in nearest] or [0] * len(features), dtype=np.intp)
        new = np.flatnonzero(bits > NOVEL)[: WORDS - len(self._words)]
        words[new], bits[new] = len(self._words) + np.arange(len(new)), 0.0
        self._words = np.concatenate([self._words, features[new]])
        return np.sqrt(np.bincount(words[bits <= NOVEL], minlength=WORDS)).astype(np.float32)
