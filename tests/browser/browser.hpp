// A headless Chromium that tests look at pages with, as their reader would: windows of any size, light and dark, mouse,
// touch and keys. It is spoken to in the Chrome DevTools protocol through a pipe.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace assur {

struct Window {
  int width = 1280, height = 900;  // CSS pixels
  bool dark = false;               // prefers-color-scheme
  bool touch = false;
};

class Browser {
 public:
  // The program; empty: this build has none, and tests skip what needs it.
  [[nodiscard]] static std::string program();

  // Everything here throws std::runtime_error for a browser that does not answer.
  Browser();
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  // A new tab in place of the old one; returns when the page is loaded.
  void open(const std::filesystem::path& page, const Window& window = {});

  // What an async function with this body returns, e.g. "return document.title". What it throws is in errors(), too.
  nlohmann::json evaluate(std::string_view body);

  // The mouse, pressed at the first point and released at the second; client coordinates.
  void drag(double x0, double y0, double x1, double y1);
  void move(double x, double y);
  void wheel(double x, double y, double down);
  // Two fingers on a horizontal line around (x, y), from one distance to another.
  void pinch(double x, double y, double from, double to);
  // A KeyboardEvent.key: "ArrowRight", "a", " ".
  void press(const std::string& key);

  // The window as PNG.
  void screenshot(const std::filesystem::path& file);

  // Since open(): messages of console.error, exceptions, the browser's own complaints, and every request that leaves
  // the page's own file.
  [[nodiscard]] const std::vector<std::string>& errors() const { return errors_; }

 private:
  nlohmann::json call(const std::string& method, nlohmann::json parameters = nlohmann::json::object());
  nlohmann::json next_message();
  void notice(const nlohmann::json& event);
  void mouse(const char* type, double x, double y, int buttons, double down = 0);
  void fingers(const char* type, double x, double y, double distance);

  std::string profile_;  // a folder of its own, removed with it
  pid_t process_ = -1;
  int to_ = -1, from_ = -1;
  std::string received_;
  std::string session_, target_;  // of the tab
  std::string page_;              // URL
  int last_call_ = 0;
  bool loaded_ = false;
  std::vector<std::string> errors_;
};

}  // namespace assur
