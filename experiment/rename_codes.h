// Two persons whom two stations gave the same code are told apart where their logs come together. A person is
// known by the station and the code there, whatever the code is in another log.
#pragma once

#include <string>
#include <vector>

#include "experiment/merge_logs.h"

namespace equilux {

/// The code that the participant had when the session was begun, at its station.
std::string find_home_code(const SessionRow& row);
/// Two sessions of one person who was given one code at one station.
bool is_same_person(const SessionRow& a, const SessionRow& b);

/// Gives the session's participant another code, and keeps the first one among its fields; back to that one
/// it is forgotten.
void give_code(SessionRow& row, const std::string& code);

/// What a tombstone must know of a withdrawn participant, so that no log brings the session back: the code
/// and, where it was another at its station, station and first code.
std::vector<std::string> list_names(const SessionRow& row);
std::string name_at_home(const SessionRow& row);  ///< station and first code
/// Of the same withdrawal, for another of these names.
Tombstone make_tombstone_beside(const Tombstone& tombstone, const std::string& name);
bool is_of_same_withdrawal(const Tombstone& a, const Tombstone& b);

/// Renames in the logs that come in, their tombstones too. What is wrong with a rename is added to
/// `conflicts`.
void rename_codes(std::vector<LogContent>& theirs, const LogContent& ours, const std::vector<Rename>& renames,
                  std::vector<std::string>& conflicts);

}  // namespace equilux
