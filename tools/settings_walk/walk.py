# SPDX-License-Identifier: GPL-3.0-or-later
"""The walk: the questions to the programs, and the verdicts of the answers on each setting."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from . import compare
from .known import PLAIN, Known, Rule
from .worker import all_asked

#: Looks with four times the samples each, of settings that few samples leave open.
LOOKS = 3
#: The verdicts, the worst last.
ORDER = ("nothing", "alike", "here alone", "apart", "failed")


@dataclass
class Row:
    """A setting and the facts about it."""

    owner: str
    name: str
    values: list[Any]
    #: The answers of jobs by context and value.
    found: list[dict[str, Any]] = field(default_factory=list)
    reason: Rule | None = None
    cause: Rule | None = None

    @property
    def verdict(self) -> str:
        """The worst of all values: "not set" where nothing was asked."""
        told = ["failed" if "failed" in one else one["verdict"] for one in self.found]
        return max(told, key=ORDER.index, default="not set")

    @property
    def worst(self) -> dict[str, Any]:
        """The answer of the worst value: where there are several, the one that is furthest apart."""
        same = [one for one in self.found if ("failed" if "failed" in one else one["verdict"]) == self.verdict]
        return max(same, key=lambda one: one["apart"]["size"] if "apart" in one else 0.0, default={})

    @property
    def is_answered(self) -> bool:
        if self.verdict in ("not set", "nothing"):
            return self.reason is not None
        if self.verdict == "alike":
            return self.reason is None
        return self.cause is not None

    @property
    def question(self) -> str:
        """The open question of a setting."""
        if self.reason is not None:
            return f"shows ({self.verdict}), though known.toml has a reason why it does not: {self.reason.why}"
        if self.verdict in ("not set", "nothing"):
            return "shows in no picture, and known.toml has no reason"
        return f"{self.verdict}: {self.worst.get('failed') or 'known.toml has no cause'}"


def rows(settings: list[tuple[str, str, list[Any]]], known: Known) -> list[Row]:
    return [
        Row(owner, name, values, reason=known.reason(owner, name), cause=known.cause(owner, name))
        for owner, name, values in settings
    ]


def walked(all_rows: list[Row], known: Known, samples: int, said: Callable[[str], None], looks: int = LOOKS) -> None:
    """Fills in the findings of all."""
    quiet = _together(all_rows, known, samples, said)
    alone = [row for row in all_rows if row.reason is None or (not row.reason.never and id(row) not in quiet)]
    asked = [
        {
            "row": index,
            "set": [[row.owner, row.name, value]],
            "in": context,
            "context": known.context(context, row.owner),
            "look": 0,
        }
        for index, row in enumerate(alone)
        for context in known.acts_in(row.owner, row.name)
        for value in row.values
    ]
    # Pictures before the change are kept by a job: one context after the other.
    asked.sort(key=lambda question: list(known.contexts).index(question["in"]))
    answers: dict[int, tuple[dict[str, Any], dict[str, Any]]] = {}
    for look in range(looks):
        open_now = asked if look == 0 else [one for one, told in answers.values() if _is_open(told, look)]
        said(f"look {look + 1}: {len(open_now)} values")

        def told(question: dict[str, Any], answer: dict[str, Any]) -> None:
            owner, name, value = question["set"][0]
            said(f"{owner}.{name} = {value} ({question['in']}): {_in_words(answer)}")
            answers[id(question)] = (question, answer)

        for question in open_now:
            question["look"] = look
        all_asked(open_now, samples, told)
    for question, answer in answers.values():
        alone[question["row"]].found.append({**answer, "value": question["set"][0][2], "in": question["in"]})


def _is_open(told: dict[str, Any], look: int) -> bool:
    """True if more samples may decide the setting."""
    if "failed" in told or told["is_clear"]:
        return False
    limit = max(told["apart"]["least"], compare.ALIKE * told["cycles"]["size"], compare.LEAST)
    if told["verdict"] in ("apart", "here alone"):
        # What is far apart is so.
        return told["apart"]["size"] < 3.0 * limit
    return look == 1


def _together(all_rows: list[Row], known: Known, samples: int, said: Callable[[str], None]) -> set[int]:
    """Sets all that have one reason at once, and where that shows, those of each owner; the ids of the rows that change nothing so."""
    waiting = [row for row in all_rows if row.reason is not None and not row.reason.never and row.values]
    quiet: set[int] = set()
    for of in (lambda row: ("all", row.reason.why), lambda row: (row.owner, row.reason.why)):
        groups: dict[tuple[str, str], list[Row]] = {}
        for row in waiting:
            groups.setdefault(of(row), []).append(row)
        questions = [
            {"group": key, "set": [[row.owner, row.name, row.values[0]] for row in group], "context": [], "look": 0}
            for key, group in groups.items()
        ]

        def told(question: dict[str, Any], answer: dict[str, Any]) -> None:
            said(f"together, {': '.join(question['group'])}: {_in_words(answer)}")
            question["answer"] = answer

        said(f"{len(questions)} groups that have a reason")
        all_asked(questions, samples, told)
        noisy = [
            one for one in questions if one["answer"].get("verdict") == "nothing" and not one["answer"]["is_clear"]
        ]
        for question in noisy:
            question["look"] = 1
        all_asked(noisy, samples, told)
        for question in questions:
            if question["answer"].get("verdict") != "nothing":
                continue
            for row in groups[question["group"]]:
                quiet.add(id(row))
                row.found.append({**question["answer"], "value": row.values[0], "in": PLAIN})
        waiting = [row for row in waiting if id(row) not in quiet]
    return quiet


def _in_words(answer: dict[str, Any]) -> str:
    if "failed" in answer:
        return f"failed: {answer['failed']}"
    sizes = " ".join(
        f"{name} {answer[name]['size']:.4f} ({answer[name]['least']:.4f})" for name in ("here", "cycles", "apart")
    )
    return f"{answer['verdict']} {sizes} {answer['sizes']}"
