/// The accuracy studies: each returns its figures and a summary, and writes nothing.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "daemon/ovws/study/figure.hpp"

namespace ovws::study {

struct Settings {
  bool quick = false;  ///< fewer levels and realisations: seconds instead of minutes
  int threads = 1;
  std::uint64_t seed = 1;  ///< the same seed gives the same numbers, whatever the threads
};

/// The results of a study. A study that cannot run is a bug and throws.
struct Findings {
  nlohmann::json summary;  ///< machine-readable
  std::vector<Figure> figures;
};

Findings localisation(const Settings& settings);
Findings wavefront(const Settings& settings);
Findings trackers(const Settings& settings);
Findings kernel(const Settings& settings);
Findings range(const Settings& settings);
Findings acquisition(const Settings& settings);
Findings oracle(const Settings& settings);
Findings operators(const Settings& settings);
Findings modes(const Settings& settings);

struct Study {
  const char* name;
  const char* what;
  Findings (*run)(const Settings&);
};
constexpr std::array<Study, 9> kStudies{{
    {"localisation", "position error of one spot against read noise", localisation},
    {"wavefront", "residual phase variance against SNR for astigmatism and defocus", wavefront},
    {"trackers", "every tracker against the Cramer-Rao bound", trackers},
    {"kernel", "the LG kernel's best radius against SNR", kernel},
    {"range", "largest amplitude of each mode with all spots found without history", range},
    {"acquisition", "fractions of spots refused and wrong without history, against SNR",
     acquisition},
    {"oracle", "lg against the paper's contour method, spot by spot", oracle},
    {"operators", "errors of every operator from displacements to modes, on the same images",
     operators},
    {"modes", "error against the number of modes, by shapes and by positions of the spots", modes},
}};

}  // namespace ovws::study
