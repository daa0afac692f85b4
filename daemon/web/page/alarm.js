// Alarm when the RMS without tilts exceeds a limit, for the page's banner and title; with a sound and a notification of the system if wanted.
import { chosen, inUnitText, remember, remembered } from "./chosen.js";

const KEPT = "alarm";
const settings = { limit: 0, sound: false, notify: false, ...remembered(KEPT, {}) }; // limit in waves, 0: none
let exceeded = null; // the RMS that exceeds the limit, waves
let audio = null;

export const alarm = settings;

export function setAlarm(name, value) {
  settings[name] = value;
  remember(KEPT, settings);
  if (name === "limit") exceeded = null;
  if (name === "sound" && value) beep();
}

/** Asks the user whether the browser may show notifications; returns whether it may. */
export async function allowNotifications() {
  return "Notification" in window && (await Notification.requestPermission()) === "granted";
}

/** Browsers allow sounds only after an action of the user on the page. */
function beep() {
  if (!navigator.userActivation.hasBeenActive) return;
  audio ??= new AudioContext();
  audio.resume();
  const [tone, volume] = [audio.createOscillator(), audio.createGain()];
  tone.frequency.value = 880;
  volume.gain.setValueAtTime(0.2, audio.currentTime);
  volume.gain.exponentialRampToValueAtTime(0.001, audio.currentTime + 0.5);
  tone.connect(volume).connect(audio.destination);
  tone.start();
  tone.stop(audio.currentTime + 0.5);
}

const text = () => `RMS ${inUnitText(exceeded)} ${chosen.unit} is above the alarm limit of ${inUnitText(settings.limit)} ${chosen.unit}`;

/** Compares the mean of half a second with the limit. `isNew`: not one of the past that the server sends to a page that connects. */
export function takeTrend(bin, isNew) {
  if (bin.bin_s >= 1) return;
  const before = exceeded;
  exceeded = settings.limit > 0 && bin.rms_waves !== null && bin.rms_waves > settings.limit ? bin.rms_waves : null;
  if (!isNew || before !== null || exceeded === null) return;
  if (settings.sound) beep();
  if (settings.notify && "Notification" in window && Notification.permission === "granted") new Notification("ovws", { body: text() });
}

/** The findings about the bench with the alarm among them, worst first. */
export function withAlarm(findings) {
  if (exceeded === null) return findings;
  const finding = { wellness: "warning", text: text(), action: { label: "History", section: "trends" } };
  const worse = findings.filter(({ wellness }) => wellness === "bad");
  return [...worse, finding, ...findings.filter(({ wellness }) => !["bad", "good"].includes(wellness))];
}
