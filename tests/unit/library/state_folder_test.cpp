#include "daemon/ovwsd/library/state_folder.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include "daemon/shared/atomic_file.hpp"
#include "daemon/shared/encoding.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kSchema = "ovws.state.reference/1";

json content_of(std::span<const float> values) {
  return {{"frames", 100},
          {"text", "a \"quoted\" word, \u00b5m"},
          {"number", 0.1},
          {"picture", base64_of(values)}};
}

const std::array<float, 5> kValues{0.0F, -1.5F, std::nanf(""), 1e-38F,
                                   std::numeric_limits<float>::infinity()};

struct Loaded {
  std::vector<StateItem> items;
  std::vector<Error> bad;
};

Loaded load(const StateFolder& folder, const char* kind) {
  Loaded loaded;
  for (const std::string& name : folder.names(kind)) {
    auto item = folder.read(kind, name);
    if (item) {
      loaded.items.push_back(std::move(*item));
    } else {
      loaded.bad.push_back(item.error());
      EXPECT_TRUE(fs::exists(folder.path_of(kind, name)));
    }
  }
  return loaded;
}

Result<std::string> put(StateFolder& folder, const char* kind, const char* name,
                        const json& content) {
  return folder.write(kind, name, StateFolder::text_of(kind, content));
}

class Store : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(fs::path(folder_).parent_path()); }
  StateFolder open() const {
    auto store = StateFolder::open(folder_);
    EXPECT_TRUE(store);
    return *store;
  }
  bool put_new(const char* kind, const char* name) const {
    StateFolder folder = open();
    return put(folder, kind, name, {}).has_value();
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ + "/" + name, std::ios::binary) << text;
  }
  const std::string folder_ = own_folder("state_store") + "/deep";
};

TEST(Encoding, TheChecksumIsTheStandardOne) {
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Encoding, FloatsKeepTheirBitsAndNothingElseIsTaken) {
  const std::string text = base64_of(kValues);
  const auto back = floats_of(text, kValues.size());
  ASSERT_TRUE(back);
  EXPECT_EQ(std::memcmp(back->data(), kValues.data(), sizeof kValues), 0);
  EXPECT_EQ(base64_of(std::array<float, 1>{1.0F}), "AACAPw==");
  EXPECT_FALSE(floats_of(text, kValues.size() + 1));
  EXPECT_FALSE(floats_of(text, kValues.size() - 1));
  EXPECT_FALSE(floats_of("AACAPw=", 1));
  EXPECT_FALSE(floats_of("AACA?w==", 1));
  EXPECT_FALSE(floats_of("", 1));
  EXPECT_TRUE(floats_of("", 0));
}

TEST(Seal, WhatIsSealedComesBack) {
  const json content = content_of(kValues);
  const std::string text = seal(kSchema, content);
  const auto whole = unseal(kSchema, text);
  ASSERT_TRUE(whole) << whole.error().reason;
  EXPECT_EQ(whole->content, content);
  const json plain = json::parse(text);
  EXPECT_EQ(plain["schema"], kSchema);
  EXPECT_EQ(plain["sha256"], whole->sha256);
  EXPECT_EQ(whole->sha256, sha256_hex(text.substr(0, text.find(",\n\"sha256\""))));
}

TEST(Seal, AFileThatIsCutOffAnywhereIsRefusedWithAReason) {
  const std::string text = seal(kSchema, content_of(kValues));
  for (std::size_t size = 0; size < text.size(); ++size) {
    const auto cut = unseal(kSchema, std::string_view(text).substr(0, size));
    ASSERT_FALSE(cut) << size;
    EXPECT_FALSE(cut.error().reason.empty());
  }
}

TEST(Seal, NoBitOfAFileCanFlipUnseen) {
  std::string text = seal(kSchema, content_of(kValues));
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      text[i] = char(text[i] ^ (1 << bit));
      ASSERT_FALSE(unseal(kSchema, text)) << "byte " << i << ", bit " << bit;
      text[i] = char(text[i] ^ (1 << bit));
    }
  }
  EXPECT_TRUE(unseal(kSchema, text));
}

TEST(Seal, GarbageAndOtherSchemasAreRefused) {
  std::mt19937 random(1);
  for (int n = 0; n < 2000; ++n) {
    std::string text(random() % 300, '\0');
    for (char& c : text) c = char(random());
    EXPECT_FALSE(unseal(kSchema, text));
  }
  const auto other = unseal(kSchema, seal("ovws.state.reference/2", json::object()));
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().reason.find(kSchema), std::string::npos);
  std::string nested(100000, '[');
  EXPECT_FALSE(unseal(kSchema, nested + ",\n\"sha256\": \"" + sha256_hex(nested) + "\"\n}\n"));
}

TEST_F(Store, ItemsOfAKindComeBackByNameUntilTheyAreDropped) {
  StateFolder store = open();
  const auto first = put(store, "reference", "a", content_of(kValues));
  ASSERT_TRUE(first);
  ASSERT_TRUE(put(store, "reference", "b", {{"frames", 2}}));
  ASSERT_TRUE(put(store, "matrix", "a", {{"frames", 3}}));
  ASSERT_TRUE(put(store, "reference", "b", {{"frames", 4}}));
  const auto loaded = load(open(), "reference");
  EXPECT_TRUE(loaded.bad.empty());
  ASSERT_EQ(loaded.items.size(), 2U);
  EXPECT_EQ(loaded.items[0].name, "a");
  EXPECT_EQ(loaded.items[0].content, content_of(kValues));
  EXPECT_EQ(loaded.items[0].sha256, *first);
  EXPECT_EQ(loaded.items[1].content["frames"], 4);
  ASSERT_TRUE(store.remove("reference", "a"));
  ASSERT_TRUE(store.remove("reference", "a"));
  EXPECT_EQ(load(store, "reference").items.size(), 1U);
  EXPECT_EQ(load(store, "matrix").items.size(), 1U);
}

TEST_F(Store, ABadFileIsReportedAndLeftAndTheOthersAreLoaded) {
  StateFolder store = open();
  ASSERT_TRUE(put(store, "reference", "good", {{"frames", 1}}));
  write("reference.empty.json", "");
  write("reference.garbage.json", "\xff\xfe{}");
  write("reference.half.json", seal(kSchema, {{"frames", 1}}).substr(0, 60));
  fs::create_directories(folder_ + "/reference.folder.json");
  ASSERT_EQ(::mkfifo((folder_ + "/reference.pipe.json").c_str(), 0600), 0);
  const auto loaded = load(store, "reference");
  ASSERT_EQ(loaded.items.size(), 1U);
  ASSERT_EQ(loaded.bad.size(), 5U);
  for (const Error& bad : loaded.bad) EXPECT_FALSE(bad.reason.empty());
}

TEST_F(Store, OpeningMakesTheFolderAndRemovesWhatAKilledWriterLeft) {
  EXPECT_EQ(open().leftovers(), 0);
  write("reference.a.json.a1B2c3.ovws-tmp", "half");
  EXPECT_EQ(open().leftovers(), 1);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 0);
}

// Not even root can write to /proc.
TEST_F(Store, AFolderThatCannotBeMadeIsAnErrorWithTheWayOut) {
  const auto store = StateFolder::open("/proc/ovws");
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().field, "state.directory");
  EXPECT_NE(store.error().reason.find("/proc/ovws"), std::string::npos) << store.error().reason;
}

TEST_F(Store, AFolderThatCannotBeWrittenIsReadAndSaysWhy) {
  const std::string folder = "/proc/self/fdinfo";
  auto store = StateFolder::open(folder);
  ASSERT_TRUE(store) << store.error().reason;
  ASSERT_TRUE(store->why_read_only());
  EXPECT_NE(store->why_read_only()->find(folder), std::string::npos) << *store->why_read_only();
  EXPECT_FALSE(put(*store, "lut", "slm", {}));
  EXPECT_TRUE(load(*store, "lut").items.empty());
  EXPECT_FALSE(open().why_read_only());
}

/// Runs `check` in a child process with a mount namespace of its own, and returns its result: 0 if
/// all is right.
constexpr int kNoMounts = 77;
template <typename Check>
int with_mounts(const Check& check) {
  const pid_t child = fork();
  if (child == 0) {
    const bool own =
        unshare(CLONE_NEWNS) == 0 && mount("", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
    _exit(own ? check() : kNoMounts);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  return WEXITSTATUS(status);
}

TEST_F(Store, OfAReadOnlyDiskWhatWasNeverKeptIsDroppedAndWhatIsKeptIsNot) {
  ASSERT_TRUE(put_new("lut", "kept"));
  const char* folder = folder_.c_str();
  const int wrong = with_mounts([&] {
    if (mount(folder, folder, nullptr, MS_BIND, nullptr) != 0) return kNoMounts;
    if (mount("", folder, nullptr, MS_REMOUNT | MS_BIND | MS_RDONLY, nullptr) != 0) {
      return kNoMounts;
    }
    auto store = StateFolder::open(folder_);
    if (!store || !store->why_read_only()) return 1;
    if (!store->remove("lut", "never_kept")) return 2;
    const auto dropped = store->remove("lut", "kept");
    if (dropped) return 3;
    return dropped.error().reason.find("is read-only") == std::string::npos ? 4 : 0;
  });
  if (wrong == kNoMounts) GTEST_SKIP() << "this process may not mount";
  EXPECT_EQ(wrong, 0);
}

TEST_F(Store, AFullDiskIsReadAndSaysWhy) {
  fs::create_directories(folder_);
  const int wrong = with_mounts([&] {
    if (mount("none", folder_.c_str(), "tmpfs", 0, "nr_blocks=1") != 0) return kNoMounts;
    if (!put_new("lut", "slm")) return 1;
    const auto store = StateFolder::open(folder_);
    if (!store || !store->why_read_only()) return 2;
    if (!store->read("lut", "slm")) return 3;
    return store->why_read_only()->find("free some space") == std::string::npos ? 4 : 0;
  });
  if (wrong == kNoMounts) GTEST_SKIP() << "this process may not mount";
  EXPECT_EQ(wrong, 0);
}

TEST_F(Store, LeftoversThatFillTheDiskMakeRoomFirst) {
  fs::create_directories(folder_);
  const int wrong = with_mounts([&] {
    // The folder itself takes one of the two inodes.
    if (mount("none", folder_.c_str(), "tmpfs", 0, "nr_inodes=2") != 0) return kNoMounts;
    write("reference.a.json.a1B2c3.ovws-tmp", "half");
    if (replace_file(folder_ + "/full", "")) return 1;
    const auto store = StateFolder::open(folder_);
    if (!store || store->leftovers() != 1) return 2;
    return store->why_read_only() ? 3 : 0;
  });
  if (wrong == kNoMounts) GTEST_SKIP() << "this process may not mount";
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace ovws
