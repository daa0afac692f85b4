/// What a person reads on the page.
#include "daemon/ovws/screen/page.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/screen/example.hpp"
#include "tests/unit/screen/row.hpp"

namespace ovws::screen {
namespace {

using nlohmann::json;

View bench() {
  View view;
  view.status_is_current = true;
  view.status = example("status");
  view.wavefront = example("wavefront");
  view.events.push_back(example("event"));
  return view;
}

std::string page(const View& view, int width = 80, int height = 24, Choice choice = {}) {
  Canvas canvas(width, height, true);
  draw(canvas, view, choice);
  std::string text;
  for (int y = 0; y < height; ++y) text += row(canvas, y) + "\n";
  return text;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The signs of a map, row by row, blanks left out.
std::string signs(const std::vector<SpotRow>& spots, int width = 21, int height = 12) {
  View view = bench();
  view.spots = spots;
  Canvas canvas(width, height, true);
  draw_spots(canvas, canvas.all(), view);
  std::string text;
  for (int y = 1; y < height; ++y) {
    for (const char c : row(canvas, y)) text += c == ' ' ? "" : std::string(1, c);
  }
  return text;
}

TEST(BarScale, IsTheNextRoundNumber) {
  EXPECT_EQ(bar_scale_waves(0.0), 0.1);
  EXPECT_EQ(bar_scale_waves(0.11), 0.2);
  EXPECT_EQ(bar_scale_waves(0.21), 0.5);
  EXPECT_EQ(bar_scale_waves(0.6), 1.0);
  EXPECT_EQ(bar_scale_waves(30.0), 50.0);
}

TEST(Page, ShowsTheBench) {
  const std::string text = page(bench());
  for (const char* part : {"running", "SLM shows sensor, hologram 7", "loop open", "frame 1041",
                           "valid", "RMS 0.5004 wave", "oblique astigmatism", "+0.5003", "tracked",
                           "losses", "job 3 (reference.take) is done", "q quit"}) {
    EXPECT_TRUE(has(text, part)) << part << "\n" << text;
  }
  EXPECT_TRUE(has(text, "Strehl 0.000"));
}

TEST(Page, ShowsTheStandardErrorOfFittedFrames) {
  View view = bench();
  view.wavefront["sigma"] = {0.0003, 0.0004};
  EXPECT_TRUE(has(page(view), "±0.0005"));
  view.wavefront["sigma"] = {nullptr, nullptr};
  EXPECT_FALSE(has(page(view), "±0.0005"));
}

TEST(Page, SaysWhyThereAreNoNumbers) {
  View view = bench();
  view.wavefront["valid"] = false;
  view.wavefront["rms_waves"] = nullptr;
  for (json& value : view.wavefront["coefficients"]) value = nullptr;
  view.not_valid = "no reference";
  EXPECT_TRUE(has(page(view), "NOT VALID: no reference"));
  EXPECT_FALSE(has(page(view), "RMS"));
  view.wavefront = json();
  EXPECT_TRUE(has(page(view), "no frames arrive"));
  view.status["sensor"]["measurable"] = false;
  view.status["sensor"]["invalid"] = {{"reason", "too small"}, {"action", "change the region"}};
  EXPECT_TRUE(has(page(view), "too small; change the region"));
  view.status = json();
  view.silent_s = 7.0;
  EXPECT_TRUE(has(page(view), "no message for 7 s: waiting for the daemon"));
}

TEST(Page, FitsEverySize) {
  const View view = bench();
  EXPECT_TRUE(has(page(view, 63, 24), "too small"));
  EXPECT_TRUE(has(page(view, 80, 17), "too small"));
  for (int width = 1; width < 240; width += 7) {
    for (int height = 1; height < 90; height += 5) page(view, width, height);
  }
}

TEST(Page, ScrollsModesWithinTheirRange) {
  View view = bench();
  view.wavefront["j"] = json::array();
  view.wavefront["coefficients"] = json::array();
  for (int j = 1; j <= 40; ++j) {
    view.wavefront["j"].push_back(j);
    view.wavefront["coefficients"].push_back(0.001 * j);
  }
  Choice choice;
  choice.first_mode = 1 << 20;
  Canvas canvas(80, 24, true);
  draw(canvas, view, choice);
  EXPECT_LT(choice.first_mode, 40);
  EXPECT_TRUE(has(page(view, 80, 24, choice), " of 40"));
  EXPECT_TRUE(has(page(view, 80, 24, choice), "-40 of 40"));
  choice.first_mode = -5;
  draw(canvas, view, choice);
  EXPECT_EQ(choice.first_mode, 0);
}

TEST(Page, SaysThatAMessageIsOfAnotherForm) {
  for (const char* key : {"j", "coefficients", "valid", "frame_id"}) {
    View view = bench();
    view.wavefront[key] = "x";
    EXPECT_TRUE(has(page(view), "a message has an unknown format")) << key;
    view.wavefront.erase(key);
    EXPECT_TRUE(has(page(view), "a message has an unknown format")) << key;
  }
  const json status = example("status");
  for (const auto& [key, value] : status.items()) {
    View view = bench();
    view.status[key] = 3;
    page(view);
    view.status.erase(key);
    page(view);
  }
}

TEST(Page, LossesThatDoNotFitAreCounted) {
  View view = bench();
  for (const char* name : {"a", "b", "c", "d", "e", "f"}) view.losses.push_back({name, 5, 2});
  EXPECT_TRUE(has(page(view), "and 4 more")) << page(view);
  EXPECT_TRUE(has(page(view, 80, 40), "f                          5  +2"));
}

TEST(SpotMap, ShowsFoundMovedAndLost) {
  EXPECT_EQ(signs({{0, 0, 0, 0}}), "●");
  EXPECT_EQ(signs({{0.9F, 0, 0, 0}}), "●") << "less than a pixel";
  EXPECT_EQ(signs({{NAN, NAN, 0, 0}}), "✕");
  EXPECT_EQ(signs({{5, 5, NAN, NAN}}), "●") << "without a reference";
  EXPECT_EQ(signs({{NAN, NAN, NAN, NAN}}), "") << "nobody knows where";
  EXPECT_EQ(signs({}), "");
}

TEST(SpotMap, ArrowsPointAsTheCameraSees) {
  const std::vector<std::pair<SpotRow, const char*>> moved{
      {{5, 0, 0, 0}, "→"},  {{5, 5, 0, 0}, "↘"},   {{0, 5, 0, 0}, "↓"},  {{-5, 5, 0, 0}, "↙"},
      {{-5, 0, 0, 0}, "←"}, {{-5, -5, 0, 0}, "↖"}, {{0, -5, 0, 0}, "↑"}, {{5, -5, 0, 0}, "↗"}};
  for (const auto& [spot, arrow] : moved) EXPECT_EQ(signs({spot}), arrow);
}

TEST(SpotMap, KeepsTheirOrder) {
  // Right of the first; below both.
  EXPECT_EQ(signs({{0, 0, 0, 0}, {109, 0, 100, 0}, {NAN, NAN, 0, 100}}), "●→✕");
}

}  // namespace
}  // namespace ovws::screen
