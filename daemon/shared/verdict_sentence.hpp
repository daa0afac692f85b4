/// Sentences for the verdicts on frames, which every program prints.
#pragma once

#include <string>
#include <string_view>

#include "proto/names.hpp"

namespace ovws {

/// Why a frame in which `tracked` of `spots` spots are found is not valid, as one sentence without
/// a full stop; empty for a valid frame. `details`: which other source, or where the branch points
/// are.
std::string sentence_of(Verdict verdict, int tracked, int spots, std::string_view details = {});

}  // namespace ovws
