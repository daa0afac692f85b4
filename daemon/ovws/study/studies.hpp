/// The accuracy studies: each returns its items, and makes its figures and a summary from their
/// results. It writes nothing.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "daemon/ovws/study/work.hpp"

namespace ovws::study {

struct Settings {
  bool quick = false;      ///< fewer levels and realisations: seconds instead of minutes
  std::uint64_t seed = 1;  ///< the same seed gives the same numbers
};

Work localisation(const Settings& settings);
Work wavefront(const Settings& settings);
Work range(const Settings& settings);
Work acquisition(const Settings& settings);
Work modes(const Settings& settings);
Work masks(const Settings& settings);
Work scintillation(const Settings& settings);

struct Study {
  const char* name;
  const char* what;
  Work (*prepare)(const Settings&);
};
constexpr std::array<Study, 7> kStudies{{
    {"localisation", "position error of one spot against read noise", localisation},
    {"wavefront", "residual phase variance against SNR for astigmatism and defocus", wavefront},
    {"range", "largest amplitude of each mode with all spots found without history", range},
    {"acquisition", "fractions of spots refused and wrong without history, against SNR",
     acquisition},
    {"modes", "error against the number of modes, by shapes and by positions of the spots", modes},
    {"masks", "which phase mask in every subaperture gives the smallest error", masks},
    {"scintillation", "residual phase variance against the number of subapertures, by strength",
     scintillation},
}};

/// The study with this name; null: there is none.
const Study* study_named(std::string_view name);

}  // namespace ovws::study
