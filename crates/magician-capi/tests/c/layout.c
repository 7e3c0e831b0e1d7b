/*
 * Sizes and offsets in the structures of the vendor's interface, as read from the vendor's own files. Do not change a
 * number to make this compile.
 */
#include <stddef.h>

#include "DobotDll.h"

#define SIZE(type, bytes) _Static_assert(sizeof(type) == (bytes), #type)
#define AT(type, member, offset, bytes)                                                   \
    _Static_assert(offsetof(type, member) == (offset), #type "." #member);                \
    _Static_assert(sizeof(((type *)0)->member) == (bytes), "size of " #type "." #member)

SIZE(bool, 1);
SIZE(HHTTrigMode, 4);
SIZE(ArmOrientation, 4);
SIZE(ColorPort, 4);
SIZE(InfraredPort, 4);

SIZE(Pose, 32);
AT(Pose, x, 0, 4);
AT(Pose, y, 4, 4);
AT(Pose, z, 8, 4);
AT(Pose, r, 12, 4);
AT(Pose, jointAngle, 16, 16);

SIZE(Kinematics, 8);
AT(Kinematics, velocity, 0, 4);
AT(Kinematics, acceleration, 4, 4);

SIZE(HOMEParams, 16);
AT(HOMEParams, x, 0, 4);
AT(HOMEParams, y, 4, 4);
AT(HOMEParams, z, 8, 4);
AT(HOMEParams, r, 12, 4);

SIZE(HOMECmd, 4);
AT(HOMECmd, reserved, 0, 4);

SIZE(AutoLevelingCmd, 5);
AT(AutoLevelingCmd, controlFlag, 0, 1);
AT(AutoLevelingCmd, precision, 1, 4);

SIZE(EndEffectorParams, 12);
AT(EndEffectorParams, xBias, 0, 4);
AT(EndEffectorParams, yBias, 4, 4);
AT(EndEffectorParams, zBias, 8, 4);

SIZE(JOGJointParams, 32);
AT(JOGJointParams, velocity, 0, 16);
AT(JOGJointParams, acceleration, 16, 16);

SIZE(JOGCoordinateParams, 32);
AT(JOGCoordinateParams, velocity, 0, 16);
AT(JOGCoordinateParams, acceleration, 16, 16);

SIZE(JOGLParams, 8);
AT(JOGLParams, velocity, 0, 4);
AT(JOGLParams, acceleration, 4, 4);

SIZE(JOGCommonParams, 8);
AT(JOGCommonParams, velocityRatio, 0, 4);
AT(JOGCommonParams, accelerationRatio, 4, 4);

SIZE(JOGCmd, 2);
AT(JOGCmd, isJoint, 0, 1);
AT(JOGCmd, cmd, 1, 1);

SIZE(PTPJointParams, 32);
AT(PTPJointParams, velocity, 0, 16);
AT(PTPJointParams, acceleration, 16, 16);

SIZE(PTPCoordinateParams, 16);
AT(PTPCoordinateParams, xyzVelocity, 0, 4);
AT(PTPCoordinateParams, rVelocity, 4, 4);
AT(PTPCoordinateParams, xyzAcceleration, 8, 4);
AT(PTPCoordinateParams, rAcceleration, 12, 4);

SIZE(PTPLParams, 8);
AT(PTPLParams, velocity, 0, 4);
AT(PTPLParams, acceleration, 4, 4);

SIZE(PTPJumpParams, 8);
AT(PTPJumpParams, jumpHeight, 0, 4);
AT(PTPJumpParams, zLimit, 4, 4);

SIZE(PTPJump2Params, 12);
AT(PTPJump2Params, startJumpHeight, 0, 4);
AT(PTPJump2Params, endJumpHeight, 4, 4);
AT(PTPJump2Params, zLimit, 8, 4);

SIZE(PTPCommonParams, 8);
AT(PTPCommonParams, velocityRatio, 0, 4);
AT(PTPCommonParams, accelerationRatio, 4, 4);

SIZE(PTPCmd, 17);
AT(PTPCmd, ptpMode, 0, 1);
AT(PTPCmd, x, 1, 4);
AT(PTPCmd, y, 5, 4);
AT(PTPCmd, z, 9, 4);
AT(PTPCmd, r, 13, 4);

SIZE(PTPWithLCmd, 21);
AT(PTPWithLCmd, ptpMode, 0, 1);
AT(PTPWithLCmd, x, 1, 4);
AT(PTPWithLCmd, y, 5, 4);
AT(PTPWithLCmd, z, 9, 4);
AT(PTPWithLCmd, r, 13, 4);
AT(PTPWithLCmd, l, 17, 4);

SIZE(ParallelOutputCmd, 4);
AT(ParallelOutputCmd, ratio, 0, 1);
AT(ParallelOutputCmd, address, 1, 2);
AT(ParallelOutputCmd, level, 3, 1);

SIZE(CPParams, 13);
AT(CPParams, planAcc, 0, 4);
AT(CPParams, juncitionVel, 4, 4);
AT(CPParams, acc, 8, 4);
AT(CPParams, period, 8, 4);
AT(CPParams, realTimeTrack, 12, 1);

SIZE(CPCommonParams, 8);
AT(CPCommonParams, velocityRatio, 0, 4);
AT(CPCommonParams, accelerationRatio, 4, 4);

SIZE(CPCmd, 17);
AT(CPCmd, cpMode, 0, 1);
AT(CPCmd, x, 1, 4);
AT(CPCmd, y, 5, 4);
AT(CPCmd, z, 9, 4);
AT(CPCmd, velocity, 13, 4);
AT(CPCmd, power, 13, 4);

SIZE(ARCParams, 16);
AT(ARCParams, xyzVelocity, 0, 4);
AT(ARCParams, rVelocity, 4, 4);
AT(ARCParams, xyzAcceleration, 8, 4);
AT(ARCParams, rAcceleration, 12, 4);

SIZE(ARCCommonParams, 8);
AT(ARCCommonParams, velocityRatio, 0, 4);
AT(ARCCommonParams, accelerationRatio, 4, 4);

#define POINT(type, point, offset)      \
    AT(type, point, offset, 16);        \
    AT(type, point.x, (offset), 4);     \
    AT(type, point.y, (offset) + 4, 4); \
    AT(type, point.z, (offset) + 8, 4); \
    AT(type, point.r, (offset) + 12, 4)

SIZE(ARCCmd, 32);
POINT(ARCCmd, cirPoint, 0);
POINT(ARCCmd, toPoint, 16);

SIZE(CircleCmd, 36);
POINT(CircleCmd, cirPoint, 0);
POINT(CircleCmd, toPoint, 16);
AT(CircleCmd, count, 32, 4);

SIZE(WAITCmd, 4);
AT(WAITCmd, timeout, 0, 4);

SIZE(TRIGCmd, 5);
AT(TRIGCmd, address, 0, 1);
AT(TRIGCmd, mode, 1, 1);
AT(TRIGCmd, condition, 2, 1);
AT(TRIGCmd, threshold, 3, 2);

SIZE(IOMultiplexing, 2);
AT(IOMultiplexing, address, 0, 1);
AT(IOMultiplexing, multiplex, 1, 1);

SIZE(IODO, 2);
AT(IODO, address, 0, 1);
AT(IODO, level, 1, 1);

SIZE(IOPWM, 9);
AT(IOPWM, address, 0, 1);
AT(IOPWM, frequency, 1, 4);
AT(IOPWM, dutyCycle, 5, 4);

SIZE(IODI, 2);
AT(IODI, address, 0, 1);
AT(IODI, level, 1, 1);

SIZE(IOADC, 3);
AT(IOADC, address, 0, 1);
AT(IOADC, value, 1, 2);

SIZE(EMotor, 6);
AT(EMotor, index, 0, 1);
AT(EMotor, isEnabled, 1, 1);
AT(EMotor, speed, 2, 4);

SIZE(EMotorS, 10);
AT(EMotorS, index, 0, 1);
AT(EMotorS, isEnabled, 1, 1);
AT(EMotorS, speed, 2, 4);
AT(EMotorS, distance, 6, 4);

SIZE(WIFIIPAddress, 5);
AT(WIFIIPAddress, dhcp, 0, 1);
AT(WIFIIPAddress, addr, 1, 4);

SIZE(WIFINetmask, 4);
AT(WIFINetmask, addr, 0, 4);
SIZE(WIFIGateway, 4);
AT(WIFIGateway, addr, 0, 4);
SIZE(WIFIDNS, 4);
AT(WIFIDNS, addr, 0, 4);

SIZE(UserParams, 32);
AT(UserParams, params, 0, 32);

SIZE(FirmwareParams, 1);
AT(FirmwareParams, mode, 0, 1);

SIZE(FirmwareMode, 2);
AT(FirmwareMode, mode, 0, 1);
AT(FirmwareMode, ctl, 1, 1);

SIZE(PID, 22);
AT(PID, index, 0, 1);
AT(PID, controlLoop, 1, 1);
AT(PID, params.p, 2, 4);
AT(PID, params.i, 6, 4);
AT(PID, params.d, 10, 4);
AT(PID, params.v, 14, 4);
AT(PID, params.a, 18, 4);

SIZE(PluseCmd, 24);
AT(PluseCmd, j1, 0, 4);
AT(PluseCmd, j2, 4, 4);
AT(PluseCmd, j3, 8, 4);
AT(PluseCmd, j4, 12, 4);
AT(PluseCmd, e1, 16, 4);
AT(PluseCmd, e2, 20, 4);

#if FAMILY != 2
SIZE(DeviceCountInfo, 16);
AT(DeviceCountInfo, deviceRunTime, 0, 8);
AT(DeviceCountInfo, devicePowerOn, 8, 4);
AT(DeviceCountInfo, devicePowerOff, 12, 4);
#endif

#if FAMILY == 3
SIZE(CP2Cmd, 17);

SIZE(DeviceID, 12);
AT(DeviceID, deviceID1, 0, 4);
AT(DeviceID, deviceID2, 4, 4);
AT(DeviceID, deviceID3, 8, 4);

SIZE(DeviceVersion, 8);
AT(DeviceVersion, fw_majorVersion, 0, 1);
AT(DeviceVersion, fw_minorVersion, 1, 1);
AT(DeviceVersion, fw_revision, 2, 1);
AT(DeviceVersion, fw_alphaVersion, 3, 1);
AT(DeviceVersion, hw_majorVersion, 4, 1);
AT(DeviceVersion, hw_minorVersion, 5, 1);
AT(DeviceVersion, hw_revision, 6, 1);
AT(DeviceVersion, hw_alphaVersion, 7, 1);

SIZE(DevInfo, 112);
AT(DevInfo, devId, 0, 4);
AT(DevInfo, type, 4, 4);
AT(DevInfo, firmwareName, 8, 50);
AT(DevInfo, firwareVersion, 58, 50);
AT(DevInfo, runTime, 108, 4);

SIZE(ConnectInfo, 336);
AT(ConnectInfo, masterDevInfo, 0, 112);
AT(ConnectInfo, slaveDevInfo1, 112, 112);
AT(ConnectInfo, slaveDevInfo2, 224, 112);

SIZE(UpgradeFWReadyCmd, 4 + sizeof(char *));
AT(UpgradeFWReadyCmd, fwSize, 0, 4);
AT(UpgradeFWReadyCmd, md5, 4, sizeof(char *));
#endif

/* Values of the constants that programs use by name. */
#define NUMBER(name, number) _Static_assert((name) == (number), #name)

NUMBER(TriggeredOnPeriodicInterval, 1);
NUMBER(RightyArmOrientation, 1);
NUMBER(JogIdle, 0);
NUMBER(JogDNPressed, 8);
NUMBER(JogENPressed, 10);
NUMBER(PTPJUMPXYZMode, 0);
NUMBER(PTPMOVJXYZMode, 1);
NUMBER(PTPMOVLXYZMode, 2);
NUMBER(PTPJUMPANGLEMode, 3);
NUMBER(PTPMOVJANGLEMode, 4);
NUMBER(PTPMOVLANGLEMode, 5);
NUMBER(PTPMOVJANGLEINCMode, 6);
NUMBER(PTPMOVLXYZINCMode, 7);
NUMBER(PTPMOVJXYZINCMode, 8);
NUMBER(PTPJUMPMOVLXYZMode, 9);
NUMBER(CPAbsoluteMode, 1);
NUMBER(TRIGADCMode, 1);
NUMBER(TRIGInputIONotEqual, 1);
NUMBER(TRIGADCGT, 3);
NUMBER(IOFunctionDO, 1);
NUMBER(IOFunctionPWM, 2);
NUMBER(IOFunctionDI, 3);
NUMBER(IOFunctionADC, 4);
NUMBER(IOFunctionDIPU, 5);
NUMBER(IOFunctionDIPD, 6);
NUMBER(CL_PORT_GP5, 3);
NUMBER(IF_PORT_GP5, 3);
NUMBER(UART4PeripheralsCH375, 3);
NUMBER(DRIVER5_SWITCH, 7);
NUMBER(OFFLINE_MODE, 3);
NUMBER(ServoCurrentLoop, 2);
NUMBER(DobotConnect_NoError, 0);
NUMBER(DobotConnect_NotFound, 1);
NUMBER(DobotConnect_Occupied, 2);
NUMBER(DobotCommunicate_NoError, 0);
NUMBER(DobotCommunicate_BufferFull, 1);
NUMBER(DobotCommunicate_Timeout, 2);
NUMBER(DobotCommunicate_InvalidParams, 3);
#if FAMILY == 3
NUMBER(DobotCommunicate_InvalidDevice, 4);
NUMBER(DevTypeMagician, 2);
NUMBER(EndTypePen, 4);
#endif
