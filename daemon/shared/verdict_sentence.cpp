#include "daemon/shared/verdict_sentence.hpp"

#include <spdlog/fmt/fmt.h>

#include <array>

namespace ovws {
namespace {

struct Sentence {
  const char* text;          ///< {2}: details
  const char* details = "";  ///< in general
};
/// In the order of the verdicts.
constexpr std::array<Sentence, std::size_t(Verdict::spots_lost) + 1> kSentences{{
    {""},
    {"the frame is late"},
    {"hologram changing"},
    {"the frame's pattern is not certain"},
    {"the daemon has no plan yet for this hologram or camera region"},
    {"no reference: ovws reference 100"},
    {"{0} of {1} spots are found, but too close to those of {2}", "another source"},
    {"{0} of {1} spots are found, which do not determine all modes"},
    {"{0} of {1} spots are found; the light has {2}", "branch points"},
    {"{0} of {1} spots are found, but templates have not confirmed them yet"},
    {"{0} of {1} spots are found, but no wavefront explains their positions"},
    {"{0} of {1} spots are found"},
}};

}  // namespace

std::string sentence_of(Verdict verdict, int tracked, int spots, std::string_view details) {
  const auto& [text, in_general] = kSentences[std::size_t(verdict)];
  return fmt::format(fmt::runtime(text), tracked, spots, details.empty() ? in_general : details);
}

}  // namespace ovws
