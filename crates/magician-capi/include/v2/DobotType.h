/*
 * Structures and numbers of the vendor's C interface to the Dobot Magician, under the vendor's names.
 *
 * For programs that were written against the vendor's header of this name, and for new ones. Lengths are millimetres,
 * angles degrees, unless a comment says otherwise. Everything is packed; a structure here is what goes over the wire.
 */
#ifndef DOBOTTYPE_H
#define DOBOTTYPE_H

#include <stdint.h>
#ifndef __cplusplus
#include <stdbool.h>
#endif

/* Lets old C, which has no nameless unions, take them without a word. */
#if defined(__GNUC__)
#define DOBOT_NAMELESS __extension__
#else
#define DOBOT_NAMELESS
#endif
#if defined(_MSC_VER)
#pragma warning(push)
#pragma warning(disable : 4201)
#endif

#pragma pack(push)
#pragma pack(1)

/* ---- Pose ---- */

/* Where the arm is, as commanded. */
typedef struct tagPose {
    float x;             /* tool tip in the base frame, mm */
    float y;
    float z;
    float r;             /* rotation of the tool, degrees: J1 + J4 */
    float jointAngle[4]; /* J1 base, J2 rear arm, J3 forearm, J4 tool, degrees */
} Pose;

/* How fast the arm is. */
typedef struct tagKinematics {
    float velocity;     /* mm/s */
    float acceleration; /* mm/s^2 */
} Kinematics;

/* ---- Homing and levelling ---- */

/* Where the arm goes when homing ends. */
typedef struct tagHOMEParams {
    float x; /* mm */
    float y;
    float z;
    float r; /* degrees */
} HOMEParams;

typedef struct tagHOMECmd {
    uint32_t reserved; /* 0 */
} HOMECmd;

typedef struct tagAutoLevelingCmd {
    uint8_t controlFlag; /* 1 levels */
    float precision;     /* tolerance, degrees (unit not confirmed) */
} AutoLevelingCmd;

/* ---- Hand teaching ---- */

/* When the arm, moved by hand, reports a point. */
typedef enum tagHHTTrigMode {
    TriggeredOnKeyReleased,     /* when the button on the forearm is let go */
    TriggeredOnPeriodicInterval /* again and again while it is held */
} HHTTrigMode;

/* ---- End effector ---- */

/* The tool tip as seen from the end of the arm. */
typedef struct tagEndEffectorParams {
    float xBias; /* along the forearm, mm: 59.7 suction cup and gripper, 61 pen, 70 laser */
    float yBias; /* to the left, mm */
    float zBias; /* downwards, mm */
} EndEffectorParams;

/* ---- Arm orientation: arms of the SCARA kind ---- */

typedef enum tagArmOrientation {
    LeftyArmOrientation,
    RightyArmOrientation
} ArmOrientation;

/* ---- Jog ---- */

typedef struct tagJOGJointParams {
    float velocity[4];     /* J1 to J4, degrees/s */
    float acceleration[4]; /* degrees/s^2 */
} JOGJointParams;

typedef struct tagJOGCoordinateParams {
    float velocity[4];     /* x, y, z in mm/s, r in degrees/s */
    float acceleration[4]; /* mm/s^2, degrees/s^2 */
} JOGCoordinateParams;

/* The rail. */
typedef struct tagJOGLParams {
    float velocity;     /* mm/s */
    float acceleration; /* mm/s^2 */
} JOGLParams;

typedef struct tagJOGCommonParams {
    float velocityRatio;     /* percent, 1 to 100 */
    float accelerationRatio; /* percent, 1 to 100 */
} JOGCommonParams;

/* Which way a jog goes; A to D are x, y, z, r or J1 to J4, E is the rail. */
enum {
    JogIdle, /* ends it */
    JogAPPressed,
    JogANPressed,
    JogBPPressed,
    JogBNPressed,
    JogCPPressed,
    JogCNPressed,
    JogDPPressed,
    JogDNPressed,
    JogEPPressed,
    JogENPressed
};

typedef struct tagJOGCmd {
    uint8_t isJoint; /* 1 moves a joint, 0 along an axis */
    uint8_t cmd;     /* JogIdle to JogENPressed */
} JOGCmd;

/* ---- Point to point ---- */

typedef struct tagPTPJointParams {
    float velocity[4];     /* J1 to J4, degrees/s */
    float acceleration[4]; /* degrees/s^2 */
} PTPJointParams;

typedef struct tagPTPCoordinateParams {
    float xyzVelocity;     /* mm/s */
    float rVelocity;       /* degrees/s */
    float xyzAcceleration; /* mm/s^2 */
    float rAcceleration;   /* degrees/s^2 */
} PTPCoordinateParams;

/* The rail. */
typedef struct tagPTPLParams {
    float velocity;     /* mm/s */
    float acceleration; /* mm/s^2 */
} PTPLParams;

typedef struct tagPTPJumpParams {
    float jumpHeight; /* how far a jump lifts above the higher end, mm */
    float zLimit;     /* how high it goes at most, mm */
} PTPJumpParams;

typedef struct tagPTPJump2Params {
    float startJumpHeight; /* how far a jump lifts where it begins, mm */
    float endJumpHeight;   /* and where it ends, mm */
    float zLimit;          /* how high at most, mm */
} PTPJump2Params;

typedef struct tagPTPCommonParams {
    float velocityRatio;     /* percent, 1 to 100 */
    float accelerationRatio; /* percent, 1 to 100 */
} PTPCommonParams;

/* How to get there: JUMP lifts, goes across and lowers; MOVJ goes as the joints like; MOVL in a straight line. */
enum PTPMode {
    PTPJUMPXYZMode, /* to a point */
    PTPMOVJXYZMode,
    PTPMOVLXYZMode,

    PTPJUMPANGLEMode, /* to joint angles */
    PTPMOVJANGLEMode,
    PTPMOVLANGLEMode,

    PTPMOVJANGLEINCMode, /* by joint angles */
    PTPMOVLXYZINCMode,   /* by a distance, straight */
    PTPMOVJXYZINCMode,   /* by a distance, as the joints like */

    PTPJUMPMOVLXYZMode /* as JUMP, across in a straight line */
};

typedef struct tagPTPCmd {
    uint8_t ptpMode; /* PTPMode */
    float x;         /* mm; J1 in degrees in the modes of joint angles */
    float y;         /* J2 */
    float z;         /* J3 */
    float r;         /* degrees; J4 */
} PTPCmd;

/* As PTPCmd, with the rail. */
typedef struct tagPTPWithLCmd {
    uint8_t ptpMode;
    float x;
    float y;
    float z;
    float r;
    float l; /* where the rail goes, mm */
} PTPWithLCmd;

/* An output that is switched on the way. */
typedef struct tagParallelOutputCmd {
    uint8_t ratio;    /* after how much of the way, percent */
    uint16_t address; /* pin, 1 to 20 */
    uint8_t level;    /* 0 or 1 */
} ParallelOutputCmd;

/* ---- Continuous path ---- */

typedef struct tagCPParams {
    float planAcc;      /* acceleration along the path at most, mm/s^2 */
    float juncitionVel; /* speed along the path at most, mm/s; the vendor's spelling */
    DOBOT_NAMELESS union {
        float acc;    /* mm/s^2; the arm makes nothing of it */
        float period; /* time of a segment, ms, when realTimeTrack is 1 */
    };
    uint8_t realTimeTrack; /* 1: this computer sets the pace */
} CPParams;

typedef struct tagCPCommonParams {
    float velocityRatio;     /* percent, 1 to 100 */
    float accelerationRatio; /* percent, 1 to 100 */
} CPCommonParams;

enum CPMode {
    CPRelativeMode, /* from where the path is */
    CPAbsoluteMode  /* to a point */
};

typedef struct tagCPCmd {
    uint8_t cpMode; /* CPMode */
    float x;        /* mm */
    float y;
    float z;
    DOBOT_NAMELESS union {
        float velocity; /* the arm makes nothing of it (SetCPCmd) */
        float power;    /* of the laser, percent, 0 to 100 (SetCPLECmd) */
    };
} CPCmd;

/* ---- Arcs and circles ---- */

typedef struct tagARCParams {
    float xyzVelocity;     /* mm/s */
    float rVelocity;       /* degrees/s */
    float xyzAcceleration; /* mm/s^2 */
    float rAcceleration;   /* degrees/s^2 */
} ARCParams;

typedef struct tagARCCommonParams {
    float velocityRatio;     /* percent, 1 to 100 */
    float accelerationRatio; /* percent, 1 to 100 */
} ARCCommonParams;

/* An arc from where the arm is, through one point to another; mm and degrees. */
typedef struct tagARCCmd {
    struct {
        float x;
        float y;
        float z;
        float r;
    } cirPoint;
    struct {
        float x;
        float y;
        float z;
        float r;
    } toPoint;
} ARCCmd;

/* A circle from where the arm is, through two points. */
typedef struct tagCircleCmd {
    struct {
        float x;
        float y;
        float z;
        float r;
    } cirPoint;
    struct {
        float x;
        float y;
        float z;
        float r;
    } toPoint;
    uint32_t count; /* how many times round */
} CircleCmd;

/* ---- Waiting ---- */

typedef struct tagWAITCmd {
    uint32_t timeout; /* how long, ms */
} WAITCmd;

typedef enum tagTRIGMode {
    TRIGInputIOMode, /* a level */
    TRIGADCMode      /* a voltage */
} TRIGMode;

typedef enum tagTRIGInputIOCondition {
    TRIGInputIOEqual,
    TRIGInputIONotEqual
} TRIGInputIOCondition;

typedef enum tagTRIGADCCondition {
    TRIGADCLT, /* less */
    TRIGADCLE, /* less or equal */
    TRIGADCGE, /* greater or equal */
    TRIGADCGT  /* greater */
} TRIGADCCondition;

/* What the queue waits for. */
typedef struct tagTRIGCmd {
    uint8_t address;    /* pin, 1 to 20 */
    uint8_t mode;       /* TRIGMode */
    uint8_t condition;  /* TRIGInputIOCondition or TRIGADCCondition */
    uint16_t threshold; /* 0 or 1; 0 to 4095 */
} TRIGCmd;

/* ---- Inputs and outputs ---- */

typedef enum tagIOFunction {
    IOFunctionDummy, /* none */
    IOFunctionDO,    /* output */
    IOFunctionPWM,   /* output, pulses */
    IOFunctionDI,    /* input */
    IOFunctionADC,   /* input, voltage */
    IOFunctionDIPU,  /* input, pulled up */
    IOFunctionDIPD   /* input, pulled down */
} IOFunction;

typedef struct tagIOMultiplexing {
    uint8_t address;   /* pin, 1 to 20 */
    uint8_t multiplex; /* IOFunction */
} IOMultiplexing;

typedef struct tagIODO {
    uint8_t address; /* pin, 1 to 20 */
    uint8_t level;   /* 0 or 1 */
} IODO;

typedef struct tagIOPWM {
    uint8_t address; /* pin, 1 to 20 */
    float frequency; /* Hz, 10 to 1000000 */
    float dutyCycle; /* percent, 1 to 100 */
} IOPWM;

typedef struct tagIODI {
    uint8_t address; /* pin, 1 to 20 */
    uint8_t level;   /* 0 or 1 */
} IODI;

typedef struct tagIOADC {
    uint8_t address; /* pin, 1 to 20 */
    uint16_t value;  /* 0 to 4095; 4095 is 3.3 V */
} IOADC;

/* A stepper on the arm's connectors, a conveyor belt for one. */
typedef struct tagEMotor {
    uint8_t index;     /* 0 or 1 */
    uint8_t isEnabled; /* 0 or 1 */
    int32_t speed;     /* pulses/s, the sign is the direction */
} EMotor;

/* As EMotor, so far and no further. */
typedef struct tagEMotorS {
    uint8_t index;
    uint8_t isEnabled;
    int32_t speed;
    uint32_t distance; /* pulses */
} EMotorS;

/* ---- Wi-Fi ---- */

typedef struct tagWIFIIPAddress {
    uint8_t dhcp;    /* 1: the network says */
    uint8_t addr[4]; /* most significant first */
} WIFIIPAddress;

typedef struct tagWIFINetmask {
    uint8_t addr[4];
} WIFINetmask;

typedef struct tagWIFIGateway {
    uint8_t addr[4];
} WIFIGateway;

typedef struct tagWIFIDNS {
    uint8_t addr[4];
} WIFIDNS;

/* ---- Tests and firmware ---- */

typedef struct tagUserParams {
    float params[8];
} UserParams;

enum FirmwareSwitchMode {
    NO_SWITCH,
    DOBOT_SWITCH,
    PRINTING_SWITCH,
    DRIVER1_SWITCH,
    DRIVER2_SWITCH,
    DRIVER3_SWITCH,
    DRIVER4_SWITCH,
    DRIVER5_SWITCH
};

typedef struct tagFirmwareParams {
    uint8_t mode; /* FirmwareSwitchMode */
} FirmwareParams;

/* The vendor's spelling. */
enum FirewareMode {
    INVALID_MODE,
    DOBOT_MODE,
    PRINTING_MODE,
    OFFLINE_MODE
};

typedef struct tagFirmwareModes {
    uint8_t mode; /* FirewareMode */
    uint8_t ctl;  /* 0 or 1 */
} FirmwareMode;

typedef enum tagServoControlLoop {
    ServoPositionLoop,
    ServoVelocityLoop,
    ServoCurrentLoop
} ServoControlLoop;

typedef struct tagPIDParams {
    float p;
    float i;
    float d;
    float v;
    float a;
} PIDParams;

typedef struct tagPID {
    uint8_t index;
    uint8_t controlLoop; /* ServoControlLoop */
    PIDParams params;
} PID;

/* ---- What is plugged in ---- */

/* The connector of a colour sensor. */
typedef enum tagColorPort {
    CL_PORT_GP1,
    CL_PORT_GP2,
    CL_PORT_GP4,
    CL_PORT_GP5
} ColorPort;

/* The connector of an infrared sensor. */
typedef enum tagInfraredPort {
    IF_PORT_GP1,
    IF_PORT_GP2,
    IF_PORT_GP4,
    IF_PORT_GP5
} InfraredPort;

/* What the serial connector is used for. */
typedef enum tagUART4PeripheralsType {
    UART4PeripheralsUART,
    UART4PeripheralsWIFI,
    UART4PeripheralsBLE,
    UART4PeripheralsCH375
} UART4PeripheralsType;

/* Pulses for each motor; the vendor's spelling. */
typedef struct tagPluseCmd {
    float j1;
    float j2;
    float j3;
    float j4;
    float e1;
    float e2;
} PluseCmd;

/* ---- Results ---- */

/* What ConnectDobot returns. */
enum {
    DobotConnect_NoError,
    DobotConnect_NotFound, /* no port was named, and no arm was found */
    DobotConnect_Occupied  /* the port cannot be opened: it is not there, not allowed, or in use */
};

/* What all others return, SearchDobot excepted. */
enum {
    DobotCommunicate_NoError,
    DobotCommunicate_BufferFull,   /* the arm's queue is full: try again */
    DobotCommunicate_Timeout,      /* no answer, or it is unknown whether the arm took the command */
    DobotCommunicate_InvalidParams /* an argument makes no sense, or the command is not allowed */
};

#pragma pack(pop)

#if defined(_MSC_VER)
#pragma warning(pop)
#endif
#undef DOBOT_NAMELESS

#endif
