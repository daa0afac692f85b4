#include "daemon/ovws/cli/study_files.hpp"

#include <fmt/core.h>

#include <system_error>

#include "proto/json_text.hpp"
#include "proto/limits.hpp"

namespace ovws::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScript = ".gnuplot";

/// Files of the existing figures. Each gnuplot script comes after its PNG and CSV: the script
/// identifies the figure, so that a removal can continue after an interruption.
std::vector<fs::path> figure_files(const std::string& study, const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    fs::path file = entry.path();
    const std::string name = file.stem().string();
    if (file.extension() != kScript) continue;
    if (name != study && !name.starts_with(study + "-")) continue;
    for (const char* ending : {".png", ".csv", kScript}) {
      files.push_back(file.replace_extension(ending));
    }
  }
  return files;
}

/// Names of the study's files that belong to no gnuplot script.
std::vector<std::string> other_files(const std::string& study) {
  std::vector<std::string> names{"summary.json", kProvenance};
  if (study != "experiment") return names;
  names.insert(names.end(), {"cells.csv", "frames.csv", "table.txt", "experiment-residual.png"});
  for (int charge = limits::kCharge.min; charge <= limits::kCharge.max; ++charge) {
    names.push_back(fmt::format("experiment-images-charge-{}.png", charge));
  }
  return names;
}

}  // namespace

Result<void> remove_findings(const std::string& study, const fs::path& folder) {
  std::vector<fs::path> files = figure_files(study, folder);
  for (const std::string& name : other_files(study)) files.push_back(folder / name);
  for (const fs::path& file : files) {
    std::error_code error;
    fs::remove(file, error);
    if (!error) continue;
    return fail(Errc::unavailable, "output",
                file.string() + " of an earlier run cannot be removed: " + error.message());
  }
  return {};
}

Result<void> write_findings(const nlohmann::json& summary,
                            const std::vector<study::Figure>& figures, const fs::path& folder,
                            const std::function<Result<void>()>& draw_images) {
  auto done = study::write_text(json_text(summary, 2) + "\n", folder / "summary.json");
  for (const study::Figure& figure : figures) {
    if (done) done = study::write_numbers(figure, folder);
  }
  if (done) done = draw_images();
  for (const study::Figure& figure : figures) {
    if (done) done = study::draw(figure, folder);
  }
  return done;
}

}  // namespace ovws::cli
