// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "wait_for.h"

#include <nodelet/NodeletLoad.h>
#include <nodelet/NodeletUnload.h>
#include <ros/network.h>
#include <ros/ros.h>
#include <xmlrpcpp/XmlRpcClient.h>
#include <algorithm>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace ppc {

/// A nodelet manager that a test loads this package's nodelets into; those still loaded at the end are unloaded.
class NodeletManager {
 public:
  explicit NodeletManager(std::string name) : name_(std::move(name)) {}
  ~NodeletManager() {
    while (!loaded_.empty()) unload(loaded_.back());
  }
  NodeletManager(const NodeletManager&) = delete;
  NodeletManager& operator=(const NodeletManager&) = delete;

  /// `nodelet` with its namespace, which is where its topics are.
  bool load(const std::string& nodelet, const std::string& type, const std::map<std::string, std::string>& remappings = {}) {
    nodelet::NodeletLoad call;
    for (const auto& [from, to] : remappings) {
      call.request.remap_source_args.push_back(from);
      call.request.remap_target_args.push_back(to);
    }
    call.request.name = nodelet;
    call.request.type = "patch_plane_clustering/" + type;
    const std::string service = name_ + "/load_nodelet";
    // By the wall clock: the one of ROS may stand.
    if (!waitFor([&] { return ros::service::exists(service, false); }, 30.0)) return false;
    if (!ros::service::call(service, call) || !call.response.success) return false;
    loaded_.push_back(nodelet);
    return true;
  }

  bool unload(const std::string nodelet) {  // NOLINT: a copy, for the list that it is removed from
    loaded_.erase(std::remove(loaded_.begin(), loaded_.end(), nodelet), loaded_.end());
    nodelet::NodeletUnload call;
    call.request.name = nodelet;
    return ros::service::call(name_ + "/unload_nodelet", call) && call.response.success;
  }

  /// Process id; 0 if it does not answer.
  int process() const {
    XmlRpc::XmlRpcValue request, response, node;
    request[0] = ros::this_node::getName();
    request[1] = name_;
    if (!ros::master::execute("lookupNode", request, response, node, false)) return 0;
    std::string host;
    std::uint32_t port = 0;
    if (!ros::network::splitURI(std::string(node), host, port)) return 0;
    XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port));
    XmlRpc::XmlRpcValue caller, answer;
    caller[0] = ros::this_node::getName();
    if (!client.execute("getPid", caller, answer) || answer.getType() != XmlRpc::XmlRpcValue::TypeArray) return 0;
    return static_cast<int>(answer[2]);
  }

  /// Resident memory [MB].
  double memory() const {
    std::ifstream status("/proc/" + std::to_string(process()) + "/status");
    for (std::string word; status >> word;) {
      double kilobytes = 0.0;
      if (word == "VmRSS:" && status >> kilobytes) return kilobytes / 1024.0;
    }
    return 0.0;
  }

 private:
  std::string name_;
  std::vector<std::string> loaded_;
};

}  // namespace ppc
