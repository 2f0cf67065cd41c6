// Fonts, colours and input of Dear ImGui 1.86.
#include "experiment/app/gui.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_impl_glfw.h>
#include <imgui_impl_opengl3.h>
#include <imgui_internal.h>
#include <utility>

namespace equilux {
namespace {

constexpr const char* kFontPath = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr float kTextPixels = 22;
constexpr float kTitlePixels = 32;
// A key goes down in one frame and up in the next. Were that one slower than ImGui's delay of .25 s it would
// take the key for held, and a Tab would move on by two.
constexpr float kLongestFrameS = 0.05F;

// Black on grey 128 has a contrast of 5.3 to 1, white on it 3.9.
void set_colours(ImGuiStyle& style) {
  const ImVec4 black(0, 0, 0, 1);
  const ImVec4 white(0.97F, 0.97F, 0.97F, 1);
  const ImVec4 light(0.86F, 0.86F, 0.86F, 1);
  const ImVec4 pale(0.78F, 0.78F, 0.78F, 1);
  const ImVec4 clear(0, 0, 0, 0);
  ImVec4* colours = style.Colors;
  colours[ImGuiCol_Text] = black;
  colours[ImGuiCol_WindowBg] = clear;
  colours[ImGuiCol_ChildBg] = light;
  colours[ImGuiCol_Border] = black;
  colours[ImGuiCol_FrameBg] = white;
  colours[ImGuiCol_FrameBgHovered] = white;
  colours[ImGuiCol_FrameBgActive] = white;
  colours[ImGuiCol_CheckMark] = black;
  colours[ImGuiCol_Button] = light;
  colours[ImGuiCol_ButtonHovered] = white;
  colours[ImGuiCol_ButtonActive] = pale;
  colours[ImGuiCol_TextSelectedBg] = ImVec4(0.65F, 0.75F, 0.95F, 1);
  colours[ImGuiCol_NavHighlight] = black;
  colours[ImGuiCol_ScrollbarBg] = clear;
  colours[ImGuiCol_ScrollbarGrab] = pale;
}

void set_style() {
  ImGui::StyleColorsLight();
  ImGuiStyle& style = ImGui::GetStyle();
  set_colours(style);
  style.WindowBorderSize = 0;
  style.WindowPadding = ImVec2(0, 0);
  style.FrameBorderSize = 1;
  style.FrameRounding = 3;
  style.FramePadding = ImVec2(12, 8);
  style.ItemSpacing = ImVec2(12, 12);
  style.ChildRounding = 3;
}

bool is_text_key(const InputEvent& event) { return event.code >= 32 && event.code < 127; }

bool is_key(const InputEvent& event) {
  return event.kind == InputKind::kKeyPress || event.kind == InputKind::kKeyRelease ||
         event.kind == InputKind::kKeyRepeat;
}

}  // namespace

Gui::Gui(AppWindow& window, float text_scale) : window_(&window), text_scale_(text_scale) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  set_style();
  load_fonts({});
  ImGui_ImplGlfw_InitForOpenGL(window.handle(), false);
  // Without a window manager no focus is reported; the pointer is ours nevertheless.
  ImGui_ImplGlfw_CursorEnterCallback(window.handle(), 1);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

Gui::~Gui() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

void Gui::use_texts(const std::vector<ShownText>& texts) {
  if (make_glyph_ranges(texts) != glyph_ranges_) {
    load_fonts(texts);
    ImGui_ImplOpenGL3_DestroyDeviceObjects();  // made anew with the next frame
  }
  check_glyphs(*text_font_, font_name_, texts);
}

void Gui::load_fonts(const std::vector<ShownText>& texts) {
  ImFontAtlas* fonts = ImGui::GetIO().Fonts;
  fonts->Clear();
  text_font_ = title_font_ = nullptr;
  glyph_ranges_ = make_glyph_ranges(texts);
  const ImWchar* ranges = glyph_ranges_.data();
  if (std::filesystem::exists(kFontPath)) {
    font_name_ = kFontPath;
    text_font_ = fonts->AddFontFromFileTTF(kFontPath, text_scale_ * kTextPixels, nullptr, ranges);
    title_font_ = fonts->AddFontFromFileTTF(kFontPath, text_scale_ * kTitlePixels, nullptr, ranges);
  }
  if (text_font_ && title_font_) {
    fonts->Build();
    return;
  }
  font_name_ = "the plain font (package fonts-dejavu-core is missing)";
  fmt::print(stderr,
             "equilux-session: {} is missing (package fonts-dejavu-core); text is shown in a plain font\n",
             kFontPath);
  ImFontConfig config;
  config.SizePixels = text_scale_ * kTextPixels;
  text_font_ = fonts->AddFontDefault(&config);
  config.SizePixels = text_scale_ * kTitlePixels;
  title_font_ = fonts->AddFontDefault(&config);
  fonts->Build();
}

void Gui::take(const std::vector<InputEvent>& events) {
  events_.insert(events_.end(), events.begin(), events.end());
}

void Gui::skip(const std::vector<InputEvent>& events) {
  take(events);
  for (const InputEvent& event : std::exchange(events_, {})) {
    if (event.kind == InputKind::kKeyRelease || event.kind == InputKind::kMouseRelease) forward(event);
  }
}

// ImGui moves between controls and sees no text above and below them.
std::optional<float> Gui::find_scroll_target(Key key) const {
  constexpr float kLines = 3, kPageShare = 0.85F;
  const ImGuiContext& context = *ImGui::GetCurrentContext();
  const bool is_typing = context.IO.WantTextInput;
  const bool scrolls_lines = scroll_.kind == PageKind::kText && context.NavDisableHighlight;
  const float step = kLines * kTextPixels * text_scale_;
  switch (key) {
    case Key::kPageUp:
      return scroll_.at - kPageShare * scroll_.height;
    case Key::kPageDown:
      return scroll_.at + kPageShare * scroll_.height;
    case Key::kHome:
      return is_typing ? std::nullopt : std::optional(0.0F);
    case Key::kEnd:
      return is_typing ? std::nullopt : std::optional(scroll_.most);
    case Key::kUp:
      return scrolls_lines && scroll_.at > 0 ? std::optional(scroll_.at - step) : std::nullopt;
    case Key::kDown:
      return scrolls_lines && scroll_.at < scroll_.most ? std::optional(scroll_.at + step) : std::nullopt;
    default:
      return std::nullopt;
  }
}

// True for a key that scrolls. On a page of text it takes the frame off a control that may not be seen any
// more.
bool Gui::scroll_by_key(const InputEvent& event) {
  if (event.kind != InputKind::kKeyPress && event.kind != InputKind::kKeyRepeat) return false;
  const auto target = find_scroll_target(event.key);
  if (!target) return false;
  scroll_.at = std::clamp(*target, 0.0F, scroll_.most);
  scroll_target_ = scroll_.at;
  if (scroll_.kind == PageKind::kText) ImGui::GetCurrentContext()->NavDisableHighlight = true;
  return true;
}

void Gui::forward(const InputEvent& event) {
  if (scroll_by_key(event)) return;
  GLFWwindow* handle = window_->handle();
  switch (event.kind) {
    case InputKind::kKeyPress:
      return ImGui_ImplGlfw_KeyCallback(handle, event.code, event.scancode, 1, event.modifiers);
    case InputKind::kKeyRelease:
      return ImGui_ImplGlfw_KeyCallback(handle, event.code, event.scancode, 0, event.modifiers);
    case InputKind::kMousePress:
      return ImGui_ImplGlfw_MouseButtonCallback(handle, event.code, 1, event.modifiers);
    case InputKind::kMouseRelease:
      return ImGui_ImplGlfw_MouseButtonCallback(handle, event.code, 0, event.modifiers);
    case InputKind::kCharacter:
      return ImGui_ImplGlfw_CharCallback(handle, static_cast<unsigned>(event.code));
    case InputKind::kScroll:
      return ImGui_ImplGlfw_ScrollCallback(handle, event.x, event.y);
    case InputKind::kKeyRepeat:  // ImGui repeats held keys by itself
      break;
  }
}

bool Gui::has_frame() const {
  return ImGui::IsItemFocused() && !ImGui::GetCurrentContext()->NavDisableHighlight;
}

void Gui::leave_field() { ImGui::ClearActiveID(); }

// ImGui 1.86 looks at keys once a frame, so that it would miss a Tab that goes down and up between two; a
// Space too, where it presses a button and is no text.
void Gui::begin_frame() {
  while (!events_.empty()) {
    const InputEvent event = events_.front();
    events_.pop_front();
    forward(event);
    const bool is_click = event.kind == InputKind::kMousePress;
    const bool is_typing = is_text_key(event) && ImGui::GetIO().WantTextInput;
    if (is_click || (is_key(event) && !is_typing)) break;
  }
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  float& frame_s = ImGui::GetIO().DeltaTime;
  frame_s = std::min(frame_s, kLongestFrameS);
  ImGui::NewFrame();
}

void Gui::end_frame() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace equilux
