"""Codes that work once, and the credential that they are exchanged for."""

import pytest

from ecs_eco.view.guard import MINUTES, Credentials


@pytest.fixture
def clock():
    """A clock that a test turns: `clock.now` in seconds."""

    class Clock:
        now = 1000.0

        def __call__(self):
            return self.now

    return Clock()


def test_a_code_works_once(clock):
    credentials = Credentials(clock)
    code = credentials.code()
    assert credentials.is_good(code)
    assert credentials.exchange(code) == credentials.credential
    assert not credentials.is_good(code)
    assert credentials.exchange(code) is None
    assert credentials.was_good(code)


def test_a_code_expires(clock):
    credentials = Credentials(clock)
    code, short = credentials.code(), credentials.code(minutes=0.5)
    clock.now += 30
    assert credentials.exchange(short) is None
    assert credentials.was_good(short)
    clock.now += 60 * MINUTES - 31
    assert credentials.is_good(code)
    clock.now += 1
    assert credentials.exchange(code) is None


def test_the_credential_outlives_the_codes(clock):
    credentials = Credentials(clock)
    credential = credentials.exchange(credentials.code())
    clock.now += 1e9
    assert credentials.admits(credential)


@pytest.mark.parametrize("word", ["", "wrong", "\udce9", "é" * 40, "x" * 100_000])
def test_other_words_are_no_code_and_no_credential(word):
    credentials = Credentials()
    credentials.code()
    assert credentials.exchange(word) is None
    assert not credentials.was_good(word)
    assert not credentials.admits(word)


def test_each_code_and_each_credential_is_another_one_of_128_bits_at_least():
    made = [Credentials() for _ in range(50)]
    words = [word for one in made for word in (one.credential, one.code(), one.code())]
    assert len(set(words)) == 150
    assert min(map(len, words)) >= 22


def test_words_are_compared_in_constant_time(monkeypatch):
    compared = []
    credentials = Credentials()
    codes = [credentials.code() for _ in range(3)]
    monkeypatch.setattr("hmac.compare_digest", lambda a, b: compared.append((a, b)) or a == b)
    assert credentials.exchange(codes[0]) == credentials.credential
    # with all of them, also after the right one
    assert {b for _, b in compared} == {code.encode() for code in codes}
    assert credentials.admits(credentials.credential)
    assert len(compared) == 4


def test_what_was_good_once_is_remembered_within_bounds():
    credentials = Credentials()
    codes = [credentials.code() for _ in range(300)]
    for code in codes:
        credentials.exchange(code)
    assert credentials.was_good(codes[-1])
    assert not credentials.was_good(codes[0])
