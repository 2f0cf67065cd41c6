// What the order effects are drawn by, as the report tells it.
#pragma once

namespace equilux {

inline constexpr int kOrderDraws = 10000;  ///< of sign flips, where not all are tried, and of bootstraps
inline constexpr char kOrderFlipStream[] = "analysis/order/flips";
inline constexpr char kOrderBootstrapStream[] = "analysis/order/bootstrap";

}  // namespace equilux
