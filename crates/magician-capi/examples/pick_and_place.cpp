// Moves a row of parts from one side to the other, with the gripper.
//
//     make && ./pick_and_place_cpp sim        a virtual arm
//     ./pick_and_place_cpp /dev/ttyUSB0       a real one: keep clear of it, it homes first
//     ./pick_and_place_cpp                    MAGICIAN_PORT, or the first arm that is found
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <thread>

#include "DobotDll.h"

namespace {

// Calls the vendor's functions and throws on errors. Disconnects when destroyed.
class Arm {
public:
    explicit Arm(const char *port)
    {
        if (ConnectDobot(port, 115200, nullptr, nullptr) != DobotConnect_NoError)
            throw std::runtime_error(why());
    }
    Arm(const Arm &) = delete;
    Arm &operator=(const Arm &) = delete;
    ~Arm() { DisconnectDobot(); }

    // Calls a function, and retries while the arm's queue is full.
    template <typename Function, typename... Arguments>
    void operator()(Function function, Arguments... arguments) const
    {
        int code;
        while ((code = function(arguments...)) == DobotCommunicate_BufferFull)
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        if (code != DobotCommunicate_NoError)
            throw std::runtime_error(why());
    }

    // Queues a command and returns its index.
    template <typename Function, typename... Arguments>
    std::uint64_t queue(Function function, Arguments... arguments) const
    {
        std::uint64_t index = 0;
        (*this)(function, arguments..., true, &index);
        return index;
    }

    // Waits until the command with this index has finished.
    void wait(std::uint64_t index) const
    {
        for (std::uint64_t current = 0;;) {
            (*this)(GetQueuedCmdCurrentIndex, &current);
            if (current >= index)
                return;
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }

    std::uint64_t jump(float x, float y, float z) const
    {
        PTPCmd command = {PTPJUMPXYZMode, x, y, z, 0};
        return queue(SetPTPCmd, &command);
    }

    std::uint64_t grip(bool closed) const
    {
        const std::uint64_t index = queue(SetEndEffectorGripper, true, closed);
        WAITCmd moment = {500};
        queue(SetWAITCmd, &moment);
        return index;
    }

private:
    static std::string why()
    {
        char text[300] = "no reason is known";
        MagicianLastError(text, sizeof text);
        return text;
    }
};

} // namespace

int main(int argc, char **argv)
try {
    const Arm arm(argc > 1 ? argv[1] : nullptr);
    arm(SetQueuedCmdStopExec);
    arm(SetQueuedCmdClear);
    arm(ClearAllAlarmsState);
    arm(SetQueuedCmdStartExec);

    EndEffectorParams gripper = {59.7f, 0, 0};
    arm.queue(SetEndEffectorParams, &gripper);
    PTPJumpParams lift = {50, 150};
    arm.queue(SetPTPJumpParams, &lift);
    HOMECmd home = {0};
    arm.wait(arm.queue(SetHOMECmd, &home));
    std::puts("homed");

    for (int part = 0; part < 3; part++) {
        const float x = 190 + 30 * static_cast<float>(part);
        arm.jump(x, 90, 10);
        arm.grip(true);
        arm.jump(x, -90, 10);
        arm.wait(arm.grip(false));
        std::printf("part %d is over there\n", part + 1);
    }
    // Switch the pump off.
    arm.wait(arm.queue(SetEndEffectorGripper, false, false));

    Pose pose;
    arm(GetPose, &pose);
    std::printf("done at x %.1f, y %.1f, z %.1f\n", pose.x, pose.y, pose.z);
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
