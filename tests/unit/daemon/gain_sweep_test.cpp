#include "daemon/ovwsd/procedures/sweep_frames.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <thread>

#include "core/optics/lattice.hpp"
#include "core/wavefront/residual_variance.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/procedures/experiment_archive.hpp"
#include "daemon/ovwsd/procedures/gain_sweep.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"
#include "daemon/shared/encoding.hpp"
#include "tests/support/own_folder.hpp"
#include "tests/unit/daemon/sweep_frame.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::frame_at;

TEST(MeanPositions, LeaveOutWhatIsRarelyFound) {
  std::vector<SeriesFrame> frames(3, frame_at({{1, 2}, {5, 5}}));
  frames[1].spots[0].x = 4.0F;
  frames[0].spots[1] = frames[1].spots[1] = SpotFix{};
  const auto mean = mean_positions(frames);
  ASSERT_EQ(mean.size(), 2U);
  EXPECT_DOUBLE_EQ(mean[0].x, 2.0);
  EXPECT_DOUBLE_EQ(mean[0].y, 2.0);
  EXPECT_TRUE(std::isnan(mean[1].x));
  EXPECT_TRUE(mean_positions({}).empty());
}

TEST(Levels, AreMediansOfFoundSpots) {
  std::vector<SeriesFrame> frames(1, frame_at({{1, 1}, {2, 2}, {3, 3}}));
  frames[0].spots[0].level = 1000.0F;
  frames[0].spots[1] = SpotFix{};
  frames[0].spots[1].peak = 255.0F;  // lost, and saturated
  const SpotLevels levels = levels_of(frames);
  EXPECT_EQ(levels.noise_dn, 2.0);
  EXPECT_EQ(levels.peak_dn, 255.0);
  EXPECT_TRUE(std::isnan(levels_of({}).level_dn));
}

/// Spots that moved exactly as the model predicts leave only the error that was not introduced.
TEST(JudgeFrames, ReportsTheResidual) {
  const SlmGeometry slm;
  const SensorConfig sensor;
  const auto lattice = make_lattice(sensor, slm);
  ASSERT_TRUE(lattice);
  const ModeOperator model =
      slope_operator(*lattice, sensor, TrackingSettings{}, px_per_cycle(OpticsConfig{}, slm));
  const std::size_t spots = lattice->subapertures.size();
  const std::vector<Vec2> reference(spots, Vec2{100.0, 100.0});
  const Reconstructor reconstructor(model.slopes, model.modes_j, reference);
  Eigen::VectorXd waves = Eigen::VectorXd::Zero(model.slopes.cols());
  waves[2] = 0.5;   // j = 3, introduced
  waves[3] = 0.01;  // j = 4, an error
  const Eigen::VectorXd moved = model.slopes * waves;
  std::vector<Vec2> places = reference;
  for (std::size_t i = 0; i < spots; ++i) {
    places[i] = places[i] + Vec2{moved[Eigen::Index(2 * i)], moved[Eigen::Index(2 * i + 1)]};
  }
  std::vector<SeriesFrame> frames(2, frame_at(places));
  frames[0].saturated_fraction = 0.5F;
  for (SpotFix& spot : frames[1].spots) spot = SpotFix{};
  const auto judged = judge_frames(frames, reconstructor, {{3, 0.5}});
  ASSERT_EQ(judged.size(), 2U);
  const double expected = 4.0 * std::numbers::pi * std::numbers::pi * 0.01 * 0.01;
  EXPECT_NEAR(judged[0].variance_rad2, expected, 0.01 * expected);
  EXPECT_NEAR(judged[0].coefficients[2], 0.5, 1e-4);
  EXPECT_EQ(judged[0].saturated_fraction, 0.5);
  EXPECT_EQ(judged[0].tracked, int(spots));
  EXPECT_TRUE(std::isnan(judged[1].variance_rad2));
  EXPECT_TRUE(judged[1].coefficients.empty());
  EXPECT_EQ(judged[1].tracked, 0);
}

TEST(ResidualVariance, IsOfModesThatAreNotMeasuredTooIfTheyAreFound) {
  const std::vector<int> modes_j{1, 3};
  const std::vector<double> found{0.1, 0.3};
  const std::vector<Mode> introduced{{3, 0.3}, {9, 1.0}};
  const double by = 4.0 * std::numbers::pi * std::numbers::pi;
  EXPECT_NEAR(residual_variance_rad2<double>(modes_j, found, introduced), by * 0.01, 1e-12);
}

TEST(SweepBench, IsTheSameUntilAPartOfItDiffers) {
  const json before{{"camera", {{"serial", "1"}}}, {"exposure_us", 2000.0}, {"kernel_radius", 0.3}};
  json now = before;
  EXPECT_TRUE(check_same_bench(before, now));
  now["camera"] = nullptr;  // no camera connected
  now["exposure_us"] = 2001.0;
  EXPECT_TRUE(check_same_bench(before, now));
  now["camera"] = {{"serial", "2"}};
  now["exposure_us"] = 2010.0;
  const auto changed = check_same_bench(before, now);
  ASSERT_FALSE(changed);
  EXPECT_EQ(changed.error().code, Errc::refused);
  EXPECT_NE(changed.error().reason.find(": camera, exposure_us;"), std::string::npos);
}

class Experiments : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }
  struct Started {
    explicit Started(const std::optional<std::string>& folder) : store({folder}, events) {
      archive.load();
    }
    Result<void> begin(ExperimentRun run, bool anew) {
      run.anew = anew;
      archive.begin_job(run, 7);
      auto opened = archive.open(anew);
      archive.end_job();
      return opened;
    }
    StreamQueue queue;
    Events events{queue};
    DaemonStore store;
    ExperimentArchive archive{store};
  };
  static ExperimentRun run_of(int frames, double exposure_us = 2000.0) {
    const auto sweep = decode<GainSweepRun>({{"gains_db", {10}}, {"frames", frames}});
    return experiment_run(*sweep, {{"exposure_us", exposure_us}});
  }
  static json cell_of(const ExperimentRun& run, int number) {
    CellMeasured cell;
    cell.cell = number;
    cell.at = run.request.cell(std::size_t(number));
    cell.with = run.request.arms[cell.at.arm];
    return to_json(CellReport{CellSummary(cell)});
  }
  static Result<json> cell_in(ExperimentArchive& archive, int number) {
    Result<json> found = fail(Errc::internal, "", "no answer");
    archive.cell(number, [&](Result<json> cell) { found = std::move(cell); });
    return found;
  }
  std::string folder_ = own_folder("experiments");
};

TEST_F(Experiments, GoOnAfterARestartWithWhatWasMeasured) {
  const ExperimentRun run = run_of(10);
  json reported;
  {
    Started daemon(folder_);
    EXPECT_FALSE(daemon.archive.result()["known"].get<bool>());
    ASSERT_TRUE(daemon.begin(run, false));
    ReferenceMeasured reference;
    reference.arm = 2;
    reference.positions_px = {{1.5, 2.0}, {NAN, NAN}};
    daemon.archive.put_reference(2, to_json(reference));
    daemon.archive.put_cell(3, cell_of(run, 3));
    reported = daemon.archive.result();
    EXPECT_TRUE(reported["not_kept_reason"].is_null());
  }
  Started again(folder_);
  EXPECT_EQ(again.archive.result(), reported);
  ASSERT_TRUE(again.begin(run_of(10), false));  // requested again, at another time
  EXPECT_EQ(again.archive.result(), reported);
  EXPECT_TRUE(again.archive.has_cell(3));
  EXPECT_FALSE(again.archive.has_cell(2));
  const auto places = reference_places(again.archive.reference(2), 2);
  ASSERT_TRUE(places);
  EXPECT_EQ((*places)[0].x, 1.5);
  EXPECT_TRUE(std::isnan((*places)[1].x));
  EXPECT_FALSE(reference_places(again.archive.reference(1), 1));
  ASSERT_TRUE(again.begin(run, true));
  EXPECT_EQ(again.archive.result()["cells_done"], 0);
}

TEST_F(Experiments, ARunIsItsParamsOnItsBench) {
  EXPECT_EQ(run_of(10).name, run_of(10).name);
  EXPECT_NE(run_of(10).name, run_of(11).name);
  EXPECT_NE(run_of(10).name, run_of(10, 500.0).name);
  Started daemon(folder_);
  ASSERT_TRUE(daemon.begin(run_of(10), false));
  daemon.archive.put_cell(0, cell_of(run_of(10), 0));
  ASSERT_TRUE(daemon.begin(run_of(11), false));
  EXPECT_FALSE(daemon.archive.has_cell(0));
  ASSERT_TRUE(daemon.begin(run_of(10), false));
  EXPECT_TRUE(daemon.archive.has_cell(0));
}

TEST_F(Experiments, TheOldestRunGoesWithAllItsFiles) {
  Started daemon(folder_);
  for (int frames = 10; frames <= 10 + int(ExperimentArchive::kMaxRuns); ++frames) {
    ASSERT_TRUE(daemon.begin(run_of(frames), false));
    daemon.archive.put_cell(0, cell_of(run_of(frames), 0));
  }
  std::size_t files = 0;
  for (const auto& file : fs::directory_iterator(folder_)) {
    EXPECT_EQ(file.path().string().find(run_of(10).name), std::string::npos);
    ++files;
  }
  EXPECT_EQ(files, 2 * ExperimentArchive::kMaxRuns);
}

TEST_F(Experiments, AreKeptWhileMeasuredThoughTheClockWasSetBack) {
  Started daemon(folder_);
  for (int frames = 10; frames < 10 + int(ExperimentArchive::kMaxRuns); ++frames) {
    ASSERT_TRUE(daemon.begin(run_of(frames), false));
    const std::string name = run_of(frames).name;
    ASSERT_TRUE(
        daemon.store.put_and_wait("experiment", name,
                                  {{"request", to_json(run_of(frames).request)},
                                   {"bench", {{"exposure_us", 2000.0}}},
                                   {"t_begun_ns", 1},
                                   {"t_opened_ns", std::numeric_limits<std::int64_t>::max()}}));
  }
  ASSERT_TRUE(daemon.begin(run_of(20), false));
  daemon.archive.put_cell(0, cell_of(run_of(20), 0));
  std::size_t headers = 0, own = 0;
  for (const auto& file : fs::directory_iterator(folder_)) {
    headers += file.path().filename().string().starts_with("experiment.") ? 1 : 0;
    own += file.path().string().find(run_of(20).name) != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(headers, ExperimentArchive::kMaxRuns);
  EXPECT_EQ(own, 2U);
}

TEST_F(Experiments, WithoutAStoreAreMeasuredAndSaySo) {
  Started daemon(std::nullopt);
  ASSERT_TRUE(daemon.begin(run_of(10), false));
  daemon.archive.put_cell(1, cell_of(run_of(10), 1));
  EXPECT_TRUE(cell_in(daemon.archive, 1));
  EXPECT_FALSE(cell_in(daemon.archive, 0));
  EXPECT_EQ(cell_in(daemon.archive, 99).error().code, Errc::invalid);
  EXPECT_TRUE(daemon.archive.result()["not_kept_reason"].is_string());
}

/// A client that knows a job's number never sees cells of another or an earlier run.
TEST_F(Experiments, ReportTheJobsOwnRunBeforeTheDiskWasAsked) {
  Started daemon(folder_);
  ASSERT_TRUE(daemon.begin(run_of(10), false));
  daemon.archive.put_cell(1, cell_of(run_of(10), 1));
  daemon.archive.begin_job(run_of(10), 7);
  EXPECT_EQ(daemon.archive.result()["cells_done"], 1);
  ExperimentRun run = run_of(10);
  run.anew = true;
  daemon.archive.begin_job(run, 8);
  EXPECT_EQ(daemon.archive.result()["cells_done"], 0);
  EXPECT_EQ(daemon.archive.result()["t_begun_ns"], run.t_begun_ns);
  EXPECT_FALSE(cell_in(daemon.archive, 1));
  daemon.archive.begin_job(run_of(11), 9);
  EXPECT_EQ(daemon.archive.result()["run"], run_of(11).name);
  EXPECT_EQ(daemon.archive.result()["job"], 9);
  EXPECT_FALSE(cell_in(daemon.archive, 1));
}

/// The state after a kill, when only the header of the repeated run had been written: the previous
/// cells are there, and belong to another run.
TEST_F(Experiments, MeasuredAnewAreNeverMixedWithThoseOfBefore) {
  const auto kept = [&](const char* what) {
    return fs::path(folder_) / ("experiment-" + run_of(10).name + "." + what + ".json");
  };
  {
    Started daemon(folder_);
    ASSERT_TRUE(daemon.begin(run_of(10), false));
    daemon.archive.put_cell(0, cell_of(run_of(10), 0));
    fs::copy(kept("cell-00000"), folder_ + "/saved");
    ASSERT_TRUE(daemon.begin(run_of(10), true));
    EXPECT_FALSE(fs::exists(kept("cell-00000")));
    daemon.archive.put_cell(1, cell_of(run_of(10), 1));
  }
  fs::rename(folder_ + "/saved", kept("cell-00000"));
  {
    Started again(folder_);
    ASSERT_TRUE(again.begin(run_of(10), false));
    EXPECT_FALSE(again.archive.has_cell(0));
    EXPECT_TRUE(again.archive.has_cell(1));
  }
  fs::remove(fs::path(folder_) / ("experiment." + run_of(10).name + ".json"));
  Started without_header(folder_);
  ASSERT_TRUE(without_header.begin(run_of(10), false));
  EXPECT_FALSE(without_header.archive.has_cell(1));
}

TEST_F(Experiments, AreLoadedByTheNextJobIfOneIsCancelledWhileTheDiskStandsStill) {
  {
    Started daemon(folder_);
    ASSERT_TRUE(daemon.begin(run_of(10), false));
    daemon.archive.put_cell(0, cell_of(run_of(10), 0));
  }
  StreamQueue queue;
  Events events{queue};
  Disk disk;
  DaemonStore store({folder_}, events, &disk);
  ExperimentArchive archive{store};
  disk.begin();  // without a thread: it stands still
  archive.begin_job(run_of(10), 7);
  const auto stopped = archive.open(false, [] { return true; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().reason, "the job was stopped");
  archive.end_job();
  EXPECT_FALSE(archive.has_cell(0));
  std::atomic<bool> end{false};
  std::thread thread([&] {
    while (!end) disk.do_work();
    disk.on_close();
  });
  archive.begin_job(run_of(10), 8);
  EXPECT_TRUE(archive.open(false));
  EXPECT_TRUE(archive.has_cell(0));
  end = true;
  thread.join();
}

TEST_F(Experiments, MeasuredAnewFailIfTheStoreCannotRemove) {
  Started daemon(folder_);
  ASSERT_TRUE(daemon.begin(run_of(10), false));
  for (int cell = 0; cell < 2; ++cell) daemon.archive.put_cell(cell, cell_of(run_of(10), cell));
  const fs::path file = folder_ + "/experiment-" + run_of(10).name + ".cell-00000.json";
  fs::remove(file);
  fs::create_directory(file);  // unlink cannot remove a folder
  const auto opened = daemon.begin(run_of(10), true);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, Errc::unavailable);
  EXPECT_EQ(daemon.archive.result()["cells_done"], 0);
  EXPECT_FALSE(daemon.archive.has_cell(1));
  Started again(folder_);
  ASSERT_TRUE(again.begin(run_of(10), false));
  EXPECT_FALSE(again.archive.has_cell(1));  // its file is still there
}

TEST_F(Experiments, ReturnAnImageFromTheDiskOrFromMemoryIfThereIsNoDisk) {
  const auto with_image = [](int number) {
    CellMeasured cell;
    cell.cell = number;
    cell.picture = CellMeasured::Picture{1, 1, "/w=="};
    return to_json(CellReport{CellSummary(cell)});
  };
  for (const bool stored : {true, false}) {
    Started daemon(stored ? std::optional(folder_) : std::nullopt);
    ASSERT_TRUE(daemon.begin(run_of(10), false));
    daemon.archive.put_cell(0, with_image(0));
    EXPECT_EQ(cell_in(daemon.archive, 0), with_image(0));
  }
  Started again(folder_);
  EXPECT_EQ(cell_in(again.archive, 0), with_image(0));
  fs::remove(fs::path(folder_) / ("experiment-picture-" + run_of(10).name + ".picture-00000.json"));
  const auto lost = cell_in(again.archive, 0);
  ASSERT_TRUE(lost);
  EXPECT_TRUE((*lost)["picture"].is_null());
}

TEST_F(Experiments, ReportTheJobAndItsTimeLeft) {
  Started daemon(folder_);
  daemon.archive.begin_job(run_of(10), 7);
  ASSERT_TRUE(daemon.archive.open(false));
  EXPECT_EQ(daemon.archive.job_of(run_of(10).name), 7);
  EXPECT_FALSE(daemon.archive.job_of(run_of(11).name));
  EXPECT_TRUE(daemon.archive.result()["time_left_s"].is_null());
  daemon.archive.put_cell(0, cell_of(run_of(10), 0));
  EXPECT_TRUE(daemon.archive.result()["time_left_s"].is_number());
  daemon.archive.end_job();
  EXPECT_TRUE(daemon.archive.result()["job"].is_null());
}

TEST(Base64, OfBytesComesBack) {
  const std::vector<std::uint8_t> bytes{0, 255, 7, 128};
  const std::string text = base64_of(std::span(bytes));
  EXPECT_EQ(bytes_of(text, 4), bytes);
  EXPECT_FALSE(bytes_of(text, 3));
  EXPECT_FALSE(bytes_of(text, 5));
}

}  // namespace
}  // namespace ovws
