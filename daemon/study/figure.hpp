/// A figure: its numbers as CSV, and drawn by gnuplot as PNG.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.hpp"

namespace ovws::study {

struct Series {
  std::string name;
  std::vector<double> x, y;
  std::vector<double> error;  ///< one standard error of each y; empty: none is drawn
  enum class Style { line_points, line, points } style = Style::line_points;
};

struct Figure {
  std::string name;  ///< of the files, without their ending
  std::string title;
  std::string x_label, y_label;  ///< with units
  bool log_x = false, log_y = false;
  bool same_scale = false;  ///< one unit is as long in x as in y
  std::vector<Series> series{};
};

/// Writes NAME.csv (series,x,y,error) and NAME.png. Errors (Errc::unavailable): the folder cannot
/// be written; gnuplot is missing or fails, and then the CSV is there all the same.
Result<void> write_figure(const Figure& figure, const std::filesystem::path& folder);

}  // namespace ovws::study
