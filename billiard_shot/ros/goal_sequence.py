"""The order of goals to a controller that answers late, in another order, or never."""

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from rclpy.action.client import ClientGoalHandle
from rclpy.task import Future

from billiard_shot.cue.clock import steady_time

GOAL_TIMEOUT = 1.0
"""Longest time in which the controller accepts or rejects a goal [s]."""


class GoalSequence:
    """
    Sends goals of control_msgs/action/FollowJointTrajectory, and hears how they end.

    A new goal gives up the goal before it if that has not been answered. If the controller accepts
    the earlier goal later, that goal is cancelled at once: a controller with several threads may
    have begun it after the new goal. A failure is a goal that is rejected, not followed, or not
    answered within `GOAL_TIMEOUT`. It lasts until a goal is accepted.

    `send` sends a goal and returns the future of its handle; `clock` reads a steady clock [s].
    """

    def __init__(
        self, send: Callable[[Any], 'Future[Any]'], clock: Callable[[], float] = steady_time
    ) -> None:
        self._send, self._clock = send, clock
        self._sent = -np.inf  # time of the last goal [s]
        self._failure = ''
        self._newest: Future[Any] | None = None  # answer to the last goal, unless it is given up
        self._accepted: ClientGoalHandle[Any, Any, Any] | None = None  # the last accepted goal
        self._answers: deque[Future[Any]] = deque(maxlen=100)
        self._is_closed = False

    @property
    def age(self) -> float:
        """Time since the last goal was sent [s]."""
        return self._clock() - self._sent

    @property
    def awaits_answer(self) -> bool:
        """Whether the last goal has not been answered, but may still be in time."""
        return self._is_open and self.age <= GOAL_TIMEOUT

    @property
    def failure(self) -> str:
        """Return why the controller does not follow the goals; '' if it does."""
        if self._is_open and self.age > GOAL_TIMEOUT:
            return f'controller: no answer to a goal for {self.age:.2g} s'
        return self._failure

    @property
    def missing(self) -> int:
        """Number of goals and cancellations that the controller has not answered."""
        return sum(not each.done() for each in self._answers)

    def send(self, goal: Any) -> None:
        """Send a goal; give up the goal before it if that has not been answered."""
        self._failure, self._sent = self.failure, self._clock()
        self._newest = self._send(goal)
        self._answers.append(self._newest)
        self._newest.add_done_callback(self._on_answer)

    def cancel(self) -> None:
        """Cancel the last accepted goal, and give up a goal that has not been answered."""
        self._failure, self._newest = self.failure, None
        if self._accepted:
            self._answers.append(self._accepted.cancel_goal_async())
            self._accepted = None

    def close(self) -> None:
        """Ignore later answers: nothing can be sent any more."""
        self._is_closed = True

    @property
    def _is_open(self) -> bool:
        return self._newest is not None and not self._newest.done()

    def _on_answer(self, answer: 'Future[Any]') -> None:
        handle = answer.result()
        if handle is None or self._is_closed:
            return
        if answer is not self._newest:
            if handle.accepted:
                self._answers.append(handle.cancel_goal_async())
        elif handle.accepted:
            self._failure, self._accepted = '', handle
            handle.get_result_async().add_done_callback(
                lambda ended: self._on_result(answer, ended.result())
            )
        else:
            self._failure = 'controller: it has rejected a goal; its log says why'
            self.cancel()

    def _on_result(self, answer: 'Future[Any]', ended: Any) -> None:
        """Note an error, unless a newer goal has replaced this one."""
        result = ended.result
        if answer is self._newest and result.error_code != result.SUCCESSFUL:
            code, constants = result.error_code, filter(str.isupper, dir(result))
            names = (each for each in constants if getattr(result, each) == code)
            name = next(names, f'error {code}')
            self._failure = f'controller: {name}: {result.error_string}'
