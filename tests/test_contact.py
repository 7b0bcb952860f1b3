"""Contacts, events, the log of events and its windows."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pymunk_dragon.model.contact import PHASES, Contact, ContactEvent, ContactLog, ContactWindow


def event(time, phase, pair=(0, 8)):
    return ContactEvent(time=time, phase=phase, benches=pair)


def test_phases_are_the_engines_four():
    assert PHASES == ("begin", "pre_solve", "post_solve", "separate")


def test_contact_and_event_cannot_be_changed():
    contact = Contact(time=1.0, raw_time=1.1, benches=(0, 8), point=(0, 0), normal=(1, 0), depth=0.001)
    for frozen in (contact, event(1.0, "begin")):
        with pytest.raises(FrozenInstanceError):
            frozen.time = 2.0


def test_event_holds_nothing_that_its_phase_does_not_know():
    bare = event(1.0, "separate")
    assert bare.points == ()
    assert (bare.normal, bare.depth, bare.relative_velocity, bare.impulse) == (None, None, None, None)


@given(st.lists(st.sampled_from(PHASES)))
def test_log_is_a_sequence_of_its_events(phases):
    events = tuple(event(float(i), phase) for i, phase in enumerate(phases))
    log = ContactLog(events)
    assert len(log) == len(events)
    assert tuple(log) == events
    assert bool(log) is bool(events)
    assert log[1:] == ContactLog(events[1:])
    for i, one in enumerate(events):
        assert log[i] is one
        assert one in log
        assert log.index(one) == i
    assert sum(len(log.of(phase)) for phase in PHASES) == len(events)
    for phase in PHASES:
        assert [one.phase for one in log.of(phase)] == [phase] * phases.count(phase)


def test_log_refuses_an_index_beyond_its_end():
    with pytest.raises(IndexError):
        ContactLog()[0]


def test_windows_run_from_begin_to_separate_of_each_pair():
    log = ContactLog(
        (
            event(1.0, "begin", (0, 8)),
            event(1.5, "begin", (1, 9)),
            event(1.6, "pre_solve", (0, 8)),
            event(2.0, "separate", (0, 8)),
            event(3.0, "begin", (0, 8)),
            event(4.0, "separate", (0, 8)),
        )
    )
    assert log.windows() == [
        ContactWindow(benches=(0, 8), begin=1.0, end=2.0),
        ContactWindow(benches=(1, 9), begin=1.5, end=None),
        ContactWindow(benches=(0, 8), begin=3.0, end=4.0),
    ]


def test_window_of_a_contact_that_begins_and_ends_in_one_substep_is_kept():
    log = ContactLog((event(1.0, "begin"), event(1.0, "separate")))
    assert log.windows() == [ContactWindow(benches=(0, 8), begin=1.0, end=1.0)]


def test_separation_without_a_beginning_opens_no_window():
    assert ContactLog((event(1.0, "separate"), event(1.0, "pre_solve"))).windows() == []
