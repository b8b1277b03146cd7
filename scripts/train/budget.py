"""Time that a training may take, over several runs."""
import time


class Budget:
    """`total_s` seconds of training in all, of which `spent_s` were spent by runs before this one."""

    def __init__(self, total_s, spent_s=0.0, clock=time.monotonic):
        self.total_s, self.before_s, self.clock = total_s, spent_s, clock
        self.start = clock()

    def spent_s(self):
        return self.before_s + self.clock() - self.start

    def share(self):
        """0 at the beginning, 1 when all is spent."""
        return min(1.0, self.spent_s() / self.total_s) if self.total_s > 0 else 1.0

    def is_spent(self):
        return self.spent_s() >= self.total_s


class Every:
    """True once in so many seconds, first after the first of them."""

    def __init__(self, seconds, clock=time.monotonic):
        self.seconds, self.clock, self.last = seconds, clock, clock()

    def is_due(self):
        if self.clock() - self.last < self.seconds:
            return False
        self.last = self.clock()
        return True
