#include "daemon/ovwsd/settings/saved_config.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;
using Keys = std::vector<std::string>;

class SavedConfig : public testing::Test {
 protected:
  SavedConfig() {
    fs::create_directories(folder_ + "/state");
    write(path_, R"({"camera": {"exposure_us": 2000, "gain_db": 1}})");
  }
  ~SavedConfig() override { fs::remove_all(folder_); }

  static void write(const std::string& path, const std::string& text) {
    std::ofstream(path) << text;
  }
  static std::string content_of(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }
  LoadedConfig load() const { return load_with_saved(path_, folder_ + "/state").value(); }
  Keys save(const Config& in_use) const {
    const SavedValues values = values_to_save(load(), in_use);
    EXPECT_TRUE(write_saved(overlay_, values));
    return values.keys;
  }
  /// The file with an exposure of 1500 us and another tracker.
  Config changed() const {
    Config in_use = load().effective;
    in_use.camera.settings.exposure_us = 1500.5;
    in_use.tracking.tracker = TrackerKind::lg;
    return in_use;
  }
  void expect_rejected(const std::string& text, const std::string& why) const {
    write(overlay_, text);
    fs::remove(overlay_ + ".rejected");
    LoadedConfig loaded = load();
    EXPECT_TRUE(loaded.invalid) << text;
    EXPECT_NE(loaded.unused_reason.find(why), std::string::npos) << loaded.unused_reason;
    EXPECT_EQ(dump_config(loaded.effective), dump_config(loaded.file));
    EXPECT_TRUE(fs::exists(overlay_)) << "reading changes nothing";
    set_aside_if_invalid(loaded);
    EXPECT_FALSE(fs::exists(overlay_));
    EXPECT_EQ(content_of(overlay_ + ".rejected"), text);
    EXPECT_NE(describe_saved(loaded).find(".rejected"), std::string::npos);
    EXPECT_EQ(load().rejected, overlay_ + ".rejected");
    EXPECT_EQ(describe_saved(load()), "");
  }

  const std::string folder_ = own_folder("saved_config");
  const std::string path_ = folder_ + "/ovwsd.json", overlay_ = folder_ + "/state/config.json";
};

TEST_F(SavedConfig, ComesBackOverTheFileWhichStaysAsItIs) {
  const std::string file = content_of(path_);
  EXPECT_EQ(save(changed()), (Keys{"camera.exposure_us", "tracking.tracker"}));
  const LoadedConfig loaded = load();
  EXPECT_EQ(content_of(path_), file);
  EXPECT_EQ(loaded.saved, (Keys{"camera.exposure_us", "tracking.tracker"}));
  EXPECT_EQ(loaded.effective.camera.settings.exposure_us, 1500.5);
  EXPECT_EQ(loaded.effective.camera.settings.gain_db, 1.0);
  EXPECT_EQ(loaded.file.camera.settings.exposure_us, 2000.0);
  EXPECT_EQ(dump_config(loaded.effective), dump_config(changed()));
  EXPECT_EQ(describe_saved(loaded),
            "saved values active: camera.exposure_us, tracking.tracker (" + overlay_ + ")");
  EXPECT_EQ(fs::status(overlay_).permissions(), fs::perms(0644));
}

TEST_F(SavedConfig, AKeyEditedInTheFileSinceIsTheFiles) {
  save(changed());
  write(path_, R"({"camera": {"exposure_us": 3000, "gain_db": 1}, "slm": {"settle_ms": 30}})");
  const LoadedConfig loaded = load();
  EXPECT_EQ(loaded.saved, Keys{"tracking.tracker"});
  EXPECT_EQ(loaded.edited, Keys{"camera.exposure_us"});
  EXPECT_EQ(loaded.effective.camera.settings.exposure_us, 3000.0);
  EXPECT_EQ(loaded.effective.tracking.tracker, TrackerKind::lg);
  EXPECT_EQ(loaded.effective.slm.settle_ms, 30.0);
  EXPECT_NE(describe_saved(loaded).find("the file's values are used: camera.exposure_us"),
            std::string::npos);
}

TEST_F(SavedConfig, ValuesThatBelongTogetherAreOfOnePlace) {
  Config in_use = load().effective;
  in_use.camera.settings.gain_raw = 5.0;
  in_use.camera.settings.roi = {16, 32, 256, 128};
  in_use.camera.settings.pixel_format = in_use.refine.format = PixelFormat::mono12;
  in_use.refine.black_level_dn = 32.0;
  save(in_use);
  EXPECT_EQ(load().effective.camera.settings.roi, in_use.camera.settings.roi);
  write(path_, R"({"camera": {"gain_db": 2, "roi": {"width": 480}, "pixel_format": "Mono16"}})");
  const LoadedConfig loaded = load();
  EXPECT_TRUE(loaded.saved.empty()) << describe_saved(loaded);
  EXPECT_EQ(loaded.edited,
            (Keys{"camera.gain_db", "camera.gain_raw", "camera.pixel_format", "camera.roi.height",
                  "camera.roi.width", "camera.roi.x", "camera.roi.y", "refine.black_level_dn"}));
  EXPECT_EQ(loaded.effective.camera.settings.gain_db, 2.0);
  EXPECT_EQ(dump_config(loaded.effective), dump_config(loaded.file));
}

TEST_F(SavedConfig, OnlyWhatChangesAtRunTimeIsSaved) {
  Config in_use = changed();
  in_use.slm.geometry.pitch_um = 99.0;  // a change that needs a restart
  in_use.tracking.kernel_radius *= 1.1;
  EXPECT_EQ(save(in_use), (Keys{"camera.exposure_us", "tracking.tracker"}));
}

TEST_F(SavedConfig, IsRemovedWhenNothingDiffers) {
  save(changed());
  EXPECT_EQ(save(load().file), Keys{});
  EXPECT_FALSE(fs::exists(overlay_));
  EXPECT_EQ(save(load().file), Keys{});
  EXPECT_EQ(describe_saved(load()), "");
}

TEST_F(SavedConfig, OfAnotherFileIsNotUsedAndLeft) {
  save(changed());
  const std::string other = folder_ + "/other.json";
  write(other, "{}");
  for (const std::string& path : {other, std::string()}) {
    LoadedConfig loaded = load_with_saved(path, folder_ + "/state").value();
    EXPECT_NE(loaded.unused_reason.find("for another configuration file, \"" + path_ + "\""),
              std::string::npos)
        << loaded.unused_reason;
    EXPECT_EQ(dump_config(loaded.effective), dump_config(loaded.file));
    set_aside_if_invalid(loaded);
    EXPECT_TRUE(fs::exists(overlay_));
    for (const Config& in_use : {loaded.file, changed()}) {
      const auto saved = write_saved(overlay_, values_to_save(loaded, in_use));
      ASSERT_FALSE(saved) << "the other daemon's values";
      EXPECT_EQ(saved.error().field, "state.directory");
    }
  }
  // The same file under another path.
  EXPECT_EQ(load_with_saved(folder_ + "/state/../ovwsd.json", folder_ + "/state")->saved.size(),
            2U);
}

TEST_F(SavedConfig, WithoutAFileLiesOverTheDefaults) {
  LoadedConfig none = load_with_saved("", folder_ + "/state").value();
  ASSERT_TRUE(write_saved(overlay_, values_to_save(none, changed())));
  none = load_with_saved("", folder_ + "/state").value();
  EXPECT_EQ(none.effective.camera.settings.exposure_us, 1500.5);
}

TEST_F(SavedConfig, ABadOneIsSetAsideAndTheFileUsed) {
  const std::string of_file =
      R"({"file": ")" + fs::absolute(path_).lexically_normal().string() + R"(", "saved": )";
  const auto entry = [&](const std::string& key, const std::string& value,
                         const std::string& instead_of) {
    return of_file + R"({")" + key + R"(": {"value": )" + value + R"(, "instead_of": )" +
           instead_of + "}}}";
  };
  expect_rejected("", "");
  expect_rejected(of_file + "{", "");
  expect_rejected("[]", "not a file that config.save wrote");
  expect_rejected(of_file + "[]}", "not a file that config.save wrote");
  expect_rejected(of_file + R"({"camera.gain_db": 3}})", "\"value\" or \"instead_of\"");
  expect_rejected(entry("camera.gain_db", "\"high\"", "1"), "camera.gain_db");
  expect_rejected(entry("camera.gain_db", "1e9", "1"), "camera.gain_db");
  expect_rejected(entry("camera.gian_db", "1", "1"), "camera.gian_db");
  expect_rejected(entry("sensor.~9", "1", "1"), "sensor.~9");
  expect_rejected(entry("security.clients", "\"/tmp/mine\"", "null"), "security.clients");
  expect_rejected(entry("tracking.operator", "\"none\"", "\"slopes\""), "tracking.operator");
  write(overlay_, "[1]");
  LoadedConfig second = load();
  set_aside_if_invalid(second);
  EXPECT_EQ(content_of(overlay_ + ".rejected.2"), "[1]") << "no earlier one is overwritten";
  fs::create_directory(overlay_);
  EXPECT_NE(load().unused_reason.find("cannot be read"), std::string::npos);
}

TEST_F(SavedConfig, OfARunningDaemonStaysInItsStateFolder) {
  save(changed());
  const LoadedConfig running = load();
  write(path_, R"({"camera": {"exposure_us": 2000}, "state": {"directory": "elsewhere"}})");
  const LoadedConfig again = load_with_saved(path_, std::nullopt, &running).value();
  EXPECT_EQ(again.overlay, running.overlay);
  EXPECT_EQ(again.effective.camera.settings.exposure_us, 1500.5);
}

TEST_F(SavedConfig, AFileThatMakesNoSensorDoesNotCondemnIt) {
  save(changed());
  write(path_, R"({"camera": {"exposure_us": 2000, "driver": "none"}})");
  const LoadedConfig loaded = load();
  EXPECT_FALSE(loaded.invalid);
  EXPECT_EQ(loaded.file.camera.driver, loaded.effective.camera.driver);
  write(path_, "{");
  EXPECT_FALSE(load_with_saved(path_, folder_ + "/state"));
}

TEST_F(SavedConfig, BelongsToTheFileHoweverItsPathIsSpelled) {
  save(changed());
  const std::string name = "/" + fs::path(path_).filename().string();
  for (const std::string& path : {folder_ + "/state/.." + name, folder_ + "//." + name}) {
    EXPECT_EQ(load_with_saved(path, folder_ + "/state")->saved.size(), 2U) << path;
  }
  fs::create_symlink(path_, folder_ + "/link.json");
  EXPECT_EQ(load_with_saved(folder_ + "/link.json", folder_ + "/state")->saved.size(), 2U);
  fs::copy_file(path_, folder_ + "/copy.json");
  EXPECT_TRUE(load_with_saved(folder_ + "/copy.json", folder_ + "/state")->saved.empty());
}

TEST_F(SavedConfig, OfTheServiceIsFoundHoweverItsPathIsSpelled) {
  for (const char* path : {"/etc/ovws/ovwsd.json", "/etc//ovws/./ovwsd.json",
                           "/etc/ovws/../ovws/ovwsd.json", "/proc/self/root/etc/ovws/ovwsd.json"}) {
    EXPECT_EQ(service_state_folder(path), "/var/lib/ovws") << path;
  }
  for (const char* path : {"", "ovwsd.json", "/etc/ovws/ovwsd.json.default"}) {
    EXPECT_EQ(service_state_folder(path), std::nullopt) << path;
  }
  const fs::path before = fs::current_path();
  fs::current_path("/etc");
  EXPECT_EQ(service_state_folder("ovws/ovwsd.json"), "/var/lib/ovws");
  fs::current_path(before);
}

TEST_F(SavedConfig, NeedsAStateDirectoryWhichItMakesAgain) {
  ASSERT_EQ(::unsetenv("STATE_DIRECTORY"), 0);
  EXPECT_FALSE(load_with_saved(path_)->overlay);
  write(path_, R"({"state": {"directory": ")" + folder_ + R"(/own"}})");
  const LoadedConfig loaded = load();
  EXPECT_EQ(loaded.overlay, folder_ + "/own/config.json");
  EXPECT_TRUE(write_saved(*loaded.overlay, values_to_save(loaded, changed())));
  EXPECT_EQ(load().saved.size(), 2U);
}

}  // namespace
}  // namespace ovws
