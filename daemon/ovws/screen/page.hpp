/// Draws the full screen of `ovws watch`.
#pragma once

#include <string>

#include "daemon/ovws/screen/canvas.hpp"
#include "daemon/ovws/screen/view.hpp"

namespace ovws::screen {

constexpr int kMinWidth = 64, kMinHeight = 18;

/// The user's choices on the screen.
struct Choice {
  bool paused = false;
  bool help = false;
  int first_mode = 0;  ///< index of the first mode shown; draw limits the index
  std::string note;    ///< question or answer in the last row, instead of the keys; empty: none
};

/// Draws the whole screen. On a canvas smaller than kMinWidth x kMinHeight, draws only a note about
/// the size. Reports a message with an unknown format on the screen.
void draw(Canvas& canvas, const View& view, Choice& choice);

// Parts of the screen.
void draw_spots(Canvas& canvas, Rect rect, const View& view);
/// Draws the modes from `first_mode` on, one per row below the title. Clamps `first_mode` so that
/// the last page is full.
void draw_modes(Canvas& canvas, Rect rect, const View& view, int& first_mode);
void draw_latency(Canvas& canvas, Rect rect, const View& view);
void draw_losses(Canvas& canvas, Rect rect, const View& view);
void draw_events(Canvas& canvas, Rect rect, const View& view);
/// The full scale of the bars, waves: 1, 2 or 5 times a power of ten, at least 0.1.
double bar_scale_waves(double largest_waves);

}  // namespace ovws::screen
