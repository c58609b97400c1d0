// A peer of `mjsim bridge` on Fast DDS: drives robot scout, and prints each scan that it gets as a line of JSON.
//
//     fastdds_peer DOMAIN SECONDS
//
// Payloads are taken as they come and read by Fast CDR field by field, as sensor_msgs/LaserScan defines them.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::SerializedPayload_t;
using Bytes = std::vector<char>;

// A type of which only the name is known here; its samples are bytes of CDR, header and all.
class Raw : public TopicDataType {
 public:
  explicit Raw(const char* name) {
    setName(name);
    m_typeSize = 1 << 20;
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<Bytes*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = bytes.size();
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(SerializedPayload_t* payload, void* data) override {
    const char* begin = reinterpret_cast<const char*>(payload->data);
    static_cast<Bytes*>(data)->assign(begin, begin + payload->length);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

static void print_list(const char* name, const std::vector<float>& values) {
  std::printf(", \"%s\": [", name);
  for (size_t i = 0; i < values.size(); ++i) std::printf("%s\"%.9g\"", i ? ", " : "", values[i]);
  std::printf("]");
}

static void print_scan(Bytes& bytes) {
  eprosima::fastcdr::FastBuffer buffer(bytes.data(), bytes.size());
  eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::Cdr::DDS_CDR);
  int32_t sec;
  uint32_t nanosec;
  std::string frame;
  cdr.read_encapsulation();
  cdr >> sec >> nanosec >> frame;
  std::printf("{\"sec\": %d, \"nanosec\": %u, \"frame_id\": \"%s\"", sec, nanosec, frame.c_str());
  for (const char* name : {"angle_min", "angle_max", "angle_increment", "time_increment", "scan_time", "range_min",
                           "range_max"}) {
    float value;
    cdr >> value;
    std::printf(", \"%s\": \"%.9g\"", name, value);
  }
  std::vector<float> ranges, intensities;
  cdr >> ranges >> intensities;
  print_list("ranges", ranges);
  print_list("intensities", intensities);
  std::printf("}\n");
  std::fflush(stdout);
}

int main(int, char** words) {
  auto* participant = DomainParticipantFactory::get_instance()->create_participant(std::atoi(words[1]),
                                                                                   PARTICIPANT_QOS_DEFAULT);
  TypeSupport scan_type(new Raw("sensor_msgs::msg::dds_::LaserScan_"));
  TypeSupport twist_type(new Raw("geometry_msgs::msg::dds_::Twist_"));
  scan_type.register_type(participant);
  twist_type.register_type(participant);
  auto* scans = participant->create_topic("rt/scout/scan", scan_type.get_type_name(), TOPIC_QOS_DEFAULT);
  auto* twists = participant->create_topic("rt/scout/cmd_vel", twist_type.get_type_name(), TOPIC_QOS_DEFAULT);
  DataReaderQos wanted = DATAREADER_QOS_DEFAULT;
  wanted.reliability().kind = BEST_EFFORT_RELIABILITY_QOS;
  wanted.history().depth = 1000;
  auto* reader = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT)->create_datareader(scans, wanted);
  auto* writer = participant->create_publisher(PUBLISHER_QOS_DEFAULT)->create_datawriter(twists, DATAWRITER_QOS_DEFAULT);
  // 0.3 m/s forward: the header of CDR in little endian, then six doubles.
  Bytes twist(4 + 6 * sizeof(double), 0);
  const double forward = 0.3;
  twist[1] = 1;
  std::memcpy(twist.data() + 4, &forward, sizeof forward);
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(std::atof(words[2]));
  while (std::chrono::steady_clock::now() < until) {
    writer->write(&twist);
    Bytes bytes;
    SampleInfo info;
    while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK)
      if (info.valid_data) print_scan(bytes);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  std::_Exit(0);  // what is still open ends with the process
}
