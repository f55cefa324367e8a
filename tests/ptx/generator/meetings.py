"""Instructions at which threads meet: those of a warp, and barriers. Each is (what the thread asks, what it is given)."""

from operands import C_TYPES, FLOATS
from parse import PtxError

SHUFFLES = {"up": "shuffle_up", "down": "shuffle_down", "bfly": "shuffle_across", "idx": "shuffle_from"}
VOTES = {"all": "vote_all", "any": "vote_any", "uni": "vote_uniform"}


def ask(request, mask, value, *more):
    return f"ask(thread, Request::{request}, {', '.join((mask, f'std::uint64_t{{{value}}}', *more))});"


def shuffle(i, o):
    target, _, predicate = i.operands[0].partition("|")
    lane, bound, mask = (o.read(text, "u32") for text in i.operands[2:])
    given = o.write(target, "b32", "static_cast<std::uint32_t>(thread.meeting.result)")
    if predicate:
        given += " " + o.write(predicate, "pred", "thread.meeting.predicate")
    return ask(SHUFFLES[i.opcode[2]], mask, o.read(i.operands[1], "b32"), lane, bound), given


def vote(i, o):
    mask = o.read(i.operands[2], "u32")
    if i.opcode[2] == "ballot":
        given = o.write(i.operands[0], "b32", "static_cast<std::uint32_t>(thread.meeting.result)")
        return ask("ballot", mask, o.predicate(i.operands[1])), given
    return ask(VOTES[i.opcode[2]], mask, o.predicate(i.operands[1])), o.write(i.operands[0], "pred", "thread.meeting.predicate")


def match(i, o):
    target, _, predicate = i.operands[0].partition("|")
    given = o.write(target, "b32", "static_cast<std::uint32_t>(thread.meeting.result)")
    if predicate:
        given += " " + o.write(predicate, "pred", "thread.meeting.predicate")
    return ask(f"match_{i.opcode[1]}", o.read(i.operands[2], "u32"), o.read(i.operands[1], i.opcode[-1])), given


def reduce(i, o):
    kind = i.opcode[-1]
    if kind in FLOATS:
        raise PtxError("is not understood")
    value = f"static_cast<std::uint32_t>({o.read(i.operands[1], kind)})"
    asked = ask(f"reduce_{i.opcode[2]}", o.read(i.operands[2], "u32"), value, "0", "0", "true" if kind == "s32" else "false")
    return asked, o.write(i.operands[0], kind, f"static_cast<{C_TYPES[kind]}>(thread.meeting.result)")


def barrier(i, o):
    """bar.sync, barrier.sync, and bar.red.popc, .and, .or, which say something of the threads' predicates."""
    parts = [part for part in i.opcode if part not in ("cta", "aligned")]
    if parts[0] == "bar" and parts[1] == "warp":
        return ask("sync", o.read(i.operands[0], "u32"), "0"), ";"
    if parts[1] == "sync":
        number, expected = [*i.operands, "0"][:2]
        return f"await(thread, Request::sync, {o.read(number, 'u32')}, {o.read(expected, 'u32')}, false);", ";"
    if parts[1] != "red":
        raise PtxError("is not understood")
    number, expected = i.operands[1], (i.operands[2] if len(i.operands) == 4 else "0")
    asked = (f"await(thread, Request::count, {o.read(number, 'u32')}, {o.read(expected, 'u32')}, "
             f"{o.predicate(i.operands[-1])});")  # fmt: skip
    if parts[2] == "popc":
        return asked, o.write(i.operands[0], "u32", "static_cast<std::uint32_t>(thread.meeting.result)")
    holds = {"and": "thread.meeting.predicate", "or": "thread.meeting.result != 0"}[parts[2]]
    return asked, o.write(i.operands[0], "pred", holds)


TRANSLATIONS = {"shfl": shuffle, "vote": vote, "match": match, "redux": reduce, "bar": barrier, "barrier": barrier}


def outcome(instruction):
    warp = instruction.opcode[0] in ("shfl", "vote", "match", "redux") or instruction.opcode[:2] == ["bar", "warp"]
    return "Outcome::warp" if warp else "Outcome::barrier"
