"""Names that a function of a generated header cannot have: words of C and C++, and what math.h declares."""

_WORDS = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t char8_t class
co_await co_return co_yield compl concept const const_cast consteval constexpr constinit continue decltype
default delete do double dynamic_cast else enum explicit export extern false float for friend goto if inline int
long main mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public register
reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast struct switch
template this thread_local throw true try typedef typeid typename typeof typeof_unqual union unsigned using
virtual void volatile wchar_t while xor xor_eq
"""
_FUNCTIONS = """
acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh drem erf erfc exp exp10 exp2 expm1 fabs fdim
finite floor fma fmax fmin fmod frexp gamma hypot ilogb isinf isnan j0 j1 jn ldexp lgamma llrint llround log
log10 log1p log2 logb lrint lround modf nan nearbyint nextafter nexttoward pow pow10 remainder remquo rint round
scalb scalbln scalbn signbit significand sin sincos sinh sqrt tan tanh tgamma trunc y0 y1 yn
"""  # each for float and long double as well
_OTHERS = """
double_t float_t fpclassify gamma_r gammaf_r gammal_r lgamma_r lgammaf_r lgammal_r isfinite isgreater
isgreaterequal isless islessequal islessgreater isnormal isunordered math math_errhandling signgam HUGE HUGE_VAL
HUGE_VALF HUGE_VALL INFINITY MATH_ERRNO MATH_ERREXCEPT NAN
"""
_PREFIXES = ("FP_", "M_")  # of math.h's constants

TAKEN = frozenset(
    [
        *_WORDS.split(),
        *_OTHERS.split(),
        *(name + kind for name in _FUNCTIONS.split() for kind in ("", "f", "l")),
    ]
)


def is_taken(name: str) -> bool:
    """Whether an identifier means something else already in C, in C++ or in math.h."""
    return name in TAKEN or name.startswith(_PREFIXES)
