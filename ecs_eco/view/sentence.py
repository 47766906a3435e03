"""A sentence about an organism: its species and condition, and what it saw and did in its last tick."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

STARVING, HUNGRY, FED = 0.15, 0.45, 0.8  # upper limits, as fractions of maximum energy
NEGLIGIBLE = 0.4  # ratio of two components of a direction below which the smaller is not mentioned
SEEN = 0.02  # lower proximity readings are ignored
IDLE = {"none", "still", "rest"}


def sentence(state: Mapping[str, Any], foods: Sequence[str] = (), enemies: Sequence[str] = ()) -> str:
    """Return a sentence for a message "organism", given the species that it eats and those that eat it."""
    name = str(state["species"]).capitalize()
    died = state.get("died")
    if not state["alive"] and died:
        killer = f" (killer: #{died['killer']})" if died.get("killer") else ""
        end = f"{name}, {_cause(died['cause'])} at tick {died['tick']:,}{killer}{_aged(state)}"
        last = "; ".join(_thought(state, foods, enemies))
        return f"{end}; in its last tick: {last}." if last else f"{end}."
    if not state["alive"]:
        return f"{name}, not alive at this tick."
    return "; ".join([f"{name}{_aged(state)}{_fed(state)}", *_thought(state, foods, enemies)]) + "."


def _thought(state: Mapping[str, Any], foods: Sequence[str], enemies: Sequence[str]) -> list[str]:
    """Return phrases about what an organism saw and did in its last tick, if known."""
    nerves = state.get("nerves")
    if not nerves:
        return []
    seen = _seen(nerves["sensors"], state.get("channels", {}), foods, enemies)
    return [text for text in (seen, _does(nerves["actions"])) if text]


def _cause(cause: str) -> str:
    return cause if cause.partition(" ")[0].endswith(("ed", "en")) else f"died ({cause})"


def _aged(state: Mapping[str, Any]) -> str:
    if state.get("age") is None:
        return ""
    return f", {state['age']:,.0f} s old" if state["age"] else ", just born"


def _fed(state: Mapping[str, Any]) -> str:
    energy, most = state.get("energy"), state.get("energy_max")
    if energy is None or not most:
        return ""
    share = energy / most
    words = {STARVING: "starving", HUNGRY: "hungry", FED: "fed"}
    return ", " + next((word for limit, word in words.items() if share < limit), "full")


def _seen(
    sensors: Sequence[Mapping[str, Any]],
    channels: Mapping[str, Mapping[str, Any]],
    foods: Sequence[str],
    enemies: Sequence[str],
) -> str:
    """Return a phrase about the nearest targets: directions and, if `channels` gives ranges, distances."""
    value = {s["name"]: s["value"] or 0.0 for s in sensors}
    near = {name.removesuffix("_near"): v for name, v in value.items() if name.endswith("_near") and v > SEEN}
    if not near:
        return ""
    about = {target: channels.get(f"{target}_near", {}) for target in near}
    who = {
        target: about[target].get("target")
        or next((name for name in (*enemies, *foods) if target.endswith(f"_{name}")), target)
        for target in near
    }  # targets of rays begin with the sensor's name, as in "far_deer"
    lines = []
    nearest = {who[target]: target for target in sorted(near, key=lambda t: near[t])}.values()
    for target in sorted(nearest, key=lambda t: (who[t] not in enemies, -near[t]))[:2]:
        word = " (an enemy)" if who[target] in enemies else " (food)" if who[target] in foods else ""
        reach = about[target].get("range")
        far = "" if reach is None else f" {(1 - near[target]) * reach:.1f} m"
        lines.append(f"{who[target]}{word}{far} {_where(value, target)}".rstrip())
    return "saw " + (", and " if any(" and " in line for line in lines) else " and ").join(lines)


def _where(value: Mapping[str, float], target: str) -> str:
    ahead, left, up = (value.get(f"{target}_{way}", 0.0) for way in ("forward", "left", "up"))
    flat = math.hypot(ahead, left)
    if not (flat or up):
        return ""  # at the same point
    high = "above" if up > 0 else "below"
    if NEGLIGIBLE * abs(up) > flat:
        return high
    ways = [
        ("ahead" if ahead > 0 else "behind") if abs(ahead) >= NEGLIGIBLE * abs(left) else "",
        f"to the {'left' if left > 0 else 'right'}" if abs(left) >= NEGLIGIBLE * abs(ahead) else "",
        f"and {high}" if abs(up) > NEGLIGIBLE * flat else "",
    ]
    return " ".join(way for way in ways if way)


def _does(actions: Sequence[Mapping[str, Any]]) -> str:
    """Return a phrase about what the organism did, and whether the reflex or the policy decided."""
    done = [a for a in actions if not a.get("continuous") and a["decision"] and a["name"] not in IDLE]
    if not done:
        return "did nothing" if actions and not actions[0].get("continuous") else ""
    parts: dict[str, list[str]] = {
        "its reflex made it ": [],
        "its policy chose to ": [],
        "it always tries to ": [],
    }
    forced, chosen, other = parts.values()
    for a in done:
        if a["reflex"] > 0:
            forced.append(_act(a))
        elif a["probability"] is not None:
            chosen.append(f"{_act(a)} ({a['probability']:.0%} chance)")
        else:
            other.append(_act(a))
    return "; ".join(words + " and ".join(acts) for words, acts in parts.items() if acts)


def _act(action: Mapping[str, Any]) -> str:
    """Return a description of an action: "turn left", "walk", "eat"."""
    group, name = action["group"], action["name"]
    return f"{group} {name}" if group in ("turn", "climb") else str(name)
