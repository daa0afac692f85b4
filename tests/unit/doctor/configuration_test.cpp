#include "daemon/examine/machine/machine.hpp"

#include "tests/unit/doctor/expect.hpp"

namespace ovws::examine {
namespace {

TEST(DoctorConfiguration, AnInvalidFileIsAFaultThatNamesTheKeyAndTheNearestOne) {
  ConfigurationFacts facts;
  facts.path = "/etc/ovws/ovwsd.json";
  facts.config = Config{};
  expect(facts, "configuration", Severity::good);
  facts.error = Error{Errc::invalid, "camera.exposure_su", "unknown key", {}, {}, "exposure_us"};
  expect(facts, "configuration", Severity::bad,
         "in /etc/ovws/ovwsd.json: \"exposure_us\" in place of \"exposure_su\"");
  facts.error->nearest.clear();
  expect(facts, "configuration", Severity::bad, "sudoedit /etc/ovws/ovwsd.json");
  facts = read_configuration("/tmp");
  expect(facts, "configuration", Severity::bad, "namei -l /tmp");
}

TEST(DoctorConfiguration, ThatSeesNoSpotsIsAFault) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  facts.unseen = Error{Errc::invalid, "camera.roi", "19 of 19 spots fall outside"};
  expect(facts, "configuration", Severity::bad, "sudoedit a.json");
  EXPECT_NE(answers(facts)[0].text.find("camera.roi: 19 of 19 spots fall outside"),
            std::string::npos);
}

TEST(DoctorConfiguration, TheZerothOrderInTheRegionIsAWarning) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  expect(facts, "optics.zeroth_order", Severity::good);
  facts.zeroth_order = Error{Errc::invalid, "camera.roi", "the zeroth order falls at (3, 4) px"};
  expect(facts, "optics.zeroth_order", Severity::warning, "sudoedit a.json");
  facts.error = Error{Errc::invalid, "optics", "nothing fits"};
  expect(facts, "optics.zeroth_order", Severity::not_here);
}

TEST(DoctorConfiguration, NoFileIsAWarning) {
  ConfigurationFacts facts;
  facts.config = Config{};
  expect(facts, "configuration", Severity::warning, "ovws doctor --config FILE");
}

TEST(DoctorConfiguration, ThatOfARunningDaemonIsJudgedAndNamed) {
  ConfigurationFacts facts;
  facts.zeroth_order = Error{Errc::invalid, "camera.roi", "of the file"};
  judge_instead(facts, Config{}, "tcp://127.0.0.1:7702");
  expect(facts, "configuration", Severity::good);
  expect(facts, "optics.zeroth_order", Severity::good);
  facts.path = "a.json";
  const std::string meaning = named(answers(facts), "configuration").text;
  EXPECT_NE(meaning.find("a.json is valid, and the checks judge the settings that the daemon at "
                         "tcp://127.0.0.1:7702 uses"),
            std::string::npos)
      << meaning;
  facts.error = Error{Errc::invalid, "camera.exposure_su", "unknown key"};
  expect(facts, "configuration", Severity::bad, "sudoedit a.json");
  expect(facts, "optics.zeroth_order", Severity::good);
}

TEST(DoctorConfiguration, SavedValuesAreNamedAndUnusedOnesAreAWarning) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  facts.saved = "saved values active: camera.gain_db (state/config.json)";
  expect(facts, "configuration", Severity::good);
  EXPECT_NE(answers(facts)[0].text.find(facts.saved), std::string::npos);
  facts.saved_is_unused = true;
  expect(facts, "configuration", Severity::warning, "ovws call config.save");
}

TEST(DoctorConfiguration, RejectedSavedValuesAreAWarningUntilTheyAreRemoved) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  facts.rejected = "state/config.json.rejected";
  expect(facts, "configuration", Severity::warning, "sudo rm state/config.json.rejected");
}

TEST(DoctorConfiguration, KeysThatTheDaemonCannotUseAreAFaultWithTheirOwnFix) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  facts.keys.error = Error{Errc::invalid, "security.secret_key", "cannot be read"};
  facts.keys.fix = "sudo chown ovws key.json";
  expect(facts, "configuration", Severity::bad, "sudo chown ovws key.json");
  facts.keys = {Error{Errc::invalid, "control.endpoint", "others can reach it"}, "", true, ""};
  expect(facts, "configuration", Severity::bad, "sudoedit a.json");
}

TEST(DoctorConfiguration, KeysThatThisUserMayNotReadAreNotJudged) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  facts.keys.read = false;
  facts.keys.user = "ovws";
  expect(facts, "configuration", Severity::not_here, "sudo -u ovws ovws doctor --config a.json");
}

}  // namespace
}  // namespace ovws::examine
