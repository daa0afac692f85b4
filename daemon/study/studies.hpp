/// The accuracy studies: each writes figures (PNG), numbers (CSV) and returns its summary.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/result.hpp"

namespace ovws::study {

struct Settings {
  std::filesystem::path folder;  ///< exists
  bool quick = false;            ///< fewer levels and realisations: minutes become seconds
  int threads = 1;
  std::uint64_t seed = 1;  ///< the same seed gives the same numbers, whatever the threads
};

/// What a study found, for a program; errors as of write_figure. What a study cannot do by itself
/// is our own bug, and thrown.
using Summary = Result<nlohmann::json>;

Summary localisation(const Settings& settings);
Summary wavefront(const Settings& settings);
Summary trackers(const Settings& settings);
Summary kernel(const Settings& settings);
Summary range(const Settings& settings);
Summary acquisition(const Settings& settings);
Summary oracle(const Settings& settings);
Summary operators(const Settings& settings);

struct Study {
  const char* name;
  const char* what;
  Summary (*run)(const Settings&);
};
constexpr std::array<Study, 8> kStudies{{
    {"localisation", "one spot: error of its position against read noise", localisation},
    {"wavefront", "residual phase variance against SNR, astigmatism and defocus", wavefront},
    {"trackers", "every tracker against the Cramer-Rao bound", trackers},
    {"kernel", "the LG kernel's best radius against SNR", kernel},
    {"range", "largest aberration that is found without history, by mode", range},
    {"acquisition", "spots found without history: refused and wrong ones against SNR", acquisition},
    {"oracle", "lg against the paper's contour method, spot by spot", oracle},
    {"operators", "from slopes to modes: every operator on the same images", operators},
}};

}  // namespace ovws::study
