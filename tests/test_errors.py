"""Errors are typed, coded, and say where, what was expected, what was got and what to do."""

import copy
import pickle

import pytest

from phblocks import PhblocksError, errors

KINDS = {
    "DataError": (ValueError, "PH101"),
    "ArgumentTypeError": (TypeError, "PH102"),
    "DuplicateNameError": (ValueError, "PH201"),
    "UnknownNameError": (KeyError, "PH202"),
    "ForeignBlockError": (ValueError, "PH203"),
    "PortTypeError": (TypeError, "PH204"),
    "PortInUseError": (ValueError, "PH205"),
    "GapError": (ValueError, "PH206"),
    "NestingError": (ValueError, "PH207"),
    "SpaceError": (ValueError, "PH208"),
    "CausalityError": (ValueError, "PH301"),
    "DanglingPortError": (ValueError, "PH303"),
    "OverdeterminedError": (ValueError, "PH304"),
    "UnderdeterminedError": (ValueError, "PH305"),
    "HeldPortError": (ValueError, "PH306"),
    "ConstraintError": (ValueError, "PH302"),
    "UndeterminedError": (ValueError, "PH307"),
    "StructureError": (ValueError, "PH401"),
    "MethodError": (ValueError, "PH402"),
    "ApproximationError": (ValueError, "PH403"),
    "PrunedError": (ValueError, "PH404"),
    "OrientationError": (NotImplementedError, "PH405"),
    "ExportError": (ValueError, "PH501"),
    "ResultFileError": (ValueError, "PH502"),
    "ExtraMissingError": (ImportError, "PH503"),
    "StudyError": (RuntimeError, "PH601"),
    "UnreachedError": (ValueError, "PH602"),
}


def make(cls: type[PhblocksError]) -> PhblocksError:
    return cls("beam 'a'", expected="a length", got="'x'", fix="Give metres.")


@pytest.mark.parametrize(("name", "builtin", "code"), [(n, b, c) for n, (b, c) in KINDS.items()])
def test_is_a_phblocks_error_and_the_builtin_it_is_a_case_of(name, builtin, code):
    error = make(getattr(errors, name))
    assert isinstance(error, PhblocksError) and isinstance(error, builtin)
    assert error.code == code
    assert str(error) == f"[{code}] beam 'a': expected a length, got 'x'. Give metres."
    assert (error.where, error.expected, error.got, error.fix) == ("beam 'a'", "a length", "'x'", "Give metres.")


def test_every_error_has_a_code_of_its_own():
    classes = [c for c in vars(errors).values() if isinstance(c, type) and issubclass(c, PhblocksError)]
    assert {c.__name__ for c in classes} == {"PhblocksError", *KINDS}
    assert len({c.code for c in classes}) == len(classes)


@pytest.mark.parametrize("name", KINDS)
def test_comes_back_whole_from_another_process(name):
    error = make(getattr(errors, name))
    for again in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
        assert type(again) is type(error) and str(again) == str(error) and again.fix == error.fix
