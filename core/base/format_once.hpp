/// The body of fmt's formatting is compiled once, in libfmt, and not again in every file that logs:
/// half of the time of a small file. Only among the precompiled headers.
#pragma once

#include <fmt/format.h>

#if FMT_VERSION < 110000  // later versions do this themselves
FMT_BEGIN_NAMESPACE
namespace detail {
extern template void vformat_to(buffer<char>&, basic_string_view<char>,
                                basic_format_args<format_context>, locale_ref);
}
FMT_END_NAMESPACE
#endif
