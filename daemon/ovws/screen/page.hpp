/// The page that ovws watch shows on a terminal.
#pragma once

#include "daemon/ovws/screen/canvas.hpp"
#include "daemon/ovws/screen/view.hpp"

namespace ovws::screen {

constexpr int kLeastWidth = 64, kLeastHeight = 18;

/// What a person chose.
struct Choice {
  bool paused = false;
  bool help = false;
  int first_mode = 0;  ///< of those that are shown; draw keeps it in range
};

/// Draws all of it. On a page smaller than kLeastWidth x kLeastHeight only that it is too small.
/// A message of another form than this program knows is said, not drawn.
void draw(Canvas& canvas, const View& view, Choice& choice);

// The parts of it.
void draw_spots(Canvas& canvas, Rect rect, const View& view);
/// At most `rect.height` modes from `first_mode` on, which is moved so that the last page is full.
void draw_modes(Canvas& canvas, Rect rect, const View& view, int& first_mode);
void draw_latency(Canvas& canvas, Rect rect, const View& view);
void draw_losses(Canvas& canvas, Rect rect, const View& view);
void draw_events(Canvas& canvas, Rect rect, const View& view);
/// The whole width of the full scale of the bars, waves: 1, 2 or 5 times a power of ten.
double bar_scale_waves(double largest_waves);

}  // namespace ovws::screen
