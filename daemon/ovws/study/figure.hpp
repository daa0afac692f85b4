/// Figures: numbers as CSV, drawn by gnuplot as PNG.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/base/result.hpp"

namespace ovws::study {

struct Series {
  std::string name;
  std::vector<double> x, y;
  std::vector<double> error;  ///< one standard error of each y; empty: none is drawn
  /// `line` is dashed; `solid` is a line without points.
  enum class Style { line_points, line, points, solid } style = Style::line_points;
  /// Uses the colour of this series of the figure, counted from 1; 0: its own colour.
  int colour = 0;
  static constexpr int kBlack = -1;
  bool in_legend = true;
  double shift_x = 0.0;  ///< horizontal offset, so that points do not cover each other
};

struct Figure {
  std::string name;  ///< of the files, without extension
  std::string title;
  std::string x_label, y_label;  ///< with units
  bool log_x = false, log_y = false;
  bool same_scale = false;  ///< equal scales in x and y
  std::vector<Series> series{};
  double y_from = std::numeric_limits<double>::quiet_NaN();  ///< NaN: from the data
  double y_to = std::numeric_limits<double>::quiet_NaN();
  double x_step = std::numeric_limits<double>::quiet_NaN();  ///< distance of tics; NaN: automatic
};

/// Writes NAME.csv (series,x,y,error) and NAME.gnuplot, which draws NAME.png in the current folder.
/// Errors (Errc::unavailable): the folder cannot be written.
Result<void> write_numbers(const Figure& figure, const std::filesystem::path& folder);

/// Draws NAME.png from the files of write_numbers. Errors (Errc::unavailable): gnuplot is missing
/// or fails; the reason says what to do.
Result<void> draw(const Figure& figure, const std::filesystem::path& folder);

}  // namespace ovws::study
