import{i as e,n as t,t as n}from"./preact.js";import{$n as r,D as i,Dn as a,Jn as o,P as s,Tr as c,U as l,an as u,jr as d,m as f,mn as p,sr as m,ur as h,v as g,wr as _,zn as v}from"./shell.js";import{n as y}from"./sheet.js";import{O as b,st as x}from"./jobs.js";import{l as S,u as C}from"./actions.js";var w=[{name:`draw`,panel:`draw`,world:`drawing`,file:{name:`rabbit.svg`,text:`<?xml version="1.0" encoding="UTF-8"?>
<!-- A rabbit out of a hat: written for this project, to be drawn with a pen. -->
<svg xmlns="http://www.w3.org/2000/svg" width="104mm" height="112mm" viewBox="0 0 104 112"
     fill="none" stroke="black" stroke-width="0.5" stroke-linecap="round" stroke-linejoin="round">
  <!-- The brim -->
  <path d="M33.3,49.05 A31,7.5 0 0 0 14,56 A31,7.5 0 0 0 76,56 A31,7.5 0 0 0 56.7,49.05"/>
  <!-- Its opening, before and behind the rabbit -->
  <path d="M34.1,50.78 A22,4.4 0 0 0 23,54.6 A22,4.4 0 0 0 38.2,58.78"/>
  <path d="M43.4,58.99 A22,4.4 0 0 0 46.6,58.99"/>
  <path d="M51.8,58.78 A22,4.4 0 0 0 67,54.6 A22,4.4 0 0 0 55.9,50.78"/>
  <!-- The hat and its band -->
  <path d="M23,61.28 C25.5,70 26.5,80 27,88 C27.5,95.5 62.5,95.5 63,88 C63.5,80 64.5,70 67,61.28"/>
  <path d="M25.32,72 C31,78.5 59,78.5 64.68,72"/>
  <path d="M26.27,79.2 C32,85.8 58,85.8 63.73,79.2"/>
  <!-- The rabbit -->
  <path d="M36.2,58.63 C33.6,53 32,46 35.2,41.2 C36.6,39.1 38.6,37.7 40.6,37 C34.2,28 31.6,11 36,7.2 C41.2,5.6 45.4,23 44.4,35.9 C44.9,35.8 45.4,35.8 45.9,35.9 C46.2,25 50.4,8.2 55.6,7.4 C61.6,9 58.2,28 50,37.1 C52.2,38 53.8,39.3 55,41.2 C58,46 56.4,53 53.8,58.63"/>
  <path d="M41.2,33 C37.6,25 35.6,14.5 37.2,10.8 C40,11.6 42.4,24 42.3,32.4"/>
  <path d="M48.4,32.6 C49.2,24.4 51.6,13.6 54.8,10.9 C57,14.5 54.4,25.4 49.6,33"/>
  <circle cx="40.4" cy="44.4" r="1.6"/>
  <circle cx="49.6" cy="44.4" r="1.6"/>
  <circle cx="40.8" cy="44" r="0.5"/>
  <circle cx="50" cy="44" r="0.5"/>
  <path d="M43.6,47.6 C44.4,47 45.6,47 46.4,47.6 L45,49.2 Z"/>
  <path d="M45,49.2 V50.4 C44.4,51.9 42.4,51.9 41.8,50.7 M45,50.4 C45.6,51.9 47.6,51.9 48.2,50.7"/>
  <path d="M38.8,46.9 L29.6,43.6 M38.6,48 L29.4,46.4 M51.2,46.9 L60.4,43.6 M51.4,48 L60.6,46.4"/>
  <!-- Its paws -->
  <path id="paw" d="M38.2,58.4 C38,54.6 43.6,54.6 43.4,58.4 C43.4,62.4 38.2,62.4 38.2,58.4 Z M40,59.4 V61 M41.6,59.4 V61"/>
  <use href="#paw" x="8.4"/>
  <!-- The wand -->
  <g transform="translate(83,63) rotate(28)">
    <rect x="-1.6" y="-24" width="3.2" height="48" rx="0.8"/>
    <path d="M-1.6,-17 H1.6 M-1.6,17 H1.6"/>
  </g>
  <!-- What comes out of it -->
  <polygon points="78.22,19.11 79.09,23.99 83.93,25.03 79.56,27.36 80.07,32.29 76.5,28.86 71.96,30.86 74.13,26.4 70.82,22.71 75.73,23.39"/>
  <polygon points="96.37,23.45 97.66,25.65 100.18,25.31 98.49,27.21 99.59,29.5 97.26,28.48 95.42,30.24 95.68,27.7 93.44,26.5 95.92,25.96"/>
  <polygon points="20.3,26.05 21.99,29.15 25.49,28.81 23.07,31.36 24.47,34.6 21.29,33.08 18.65,35.41 19.11,31.92 16.08,30.13 19.54,29.49"/>
  <path d="M88,9.4 Q88.55,13.45 92.6,14 Q88.55,14.55 88,18.6 Q87.45,14.55 83.4,14 Q87.45,13.45 88,9.4 Z"/>
  <path d="M66,10.8 Q66.38,13.62 69.2,14 Q66.38,14.38 66,17.2 Q65.62,14.38 62.8,14 Q65.62,13.62 66,10.8 Z"/>
  <path d="M14,11.2 Q14.46,14.54 17.8,15 Q14.46,15.46 14,18.8 Q13.54,15.46 10.2,15 Q13.54,14.54 14,11.2 Z"/>
  <path d="M12,41.4 Q12.31,43.69 14.6,44 Q12.31,44.31 12,46.6 Q11.69,44.31 9.4,44 Q11.69,43.69 12,41.4 Z"/>
  <path d="M67,38.6 Q67.29,40.71 69.4,41 Q67.29,41.29 67,43.4 Q66.71,41.29 64.6,41 Q66.71,40.71 67,38.6 Z"/>
  <path d="M90,35.3 Q90.26,37.24 92.2,37.5 Q90.26,37.76 90,39.7 Q89.74,37.76 87.8,37.5 Q89.74,37.24 90,35.3 Z"/>
  <!-- Who -->
  <text x="45" y="108" font-size="13" text-anchor="middle">magician</text>
</svg>
`}},{name:`write`,panel:`draw`,world:`drawing`,text:`Hello`},{name:`stamp`,panel:`draw`,world:`drawing`,file:{name:`star.plt`,text:`IN;
VS32,1;
WU0;
PW0.350,1;
LT;
SP1;
PU1600 2600;
PD2187 791;
PD649 1909;
PD2551 1909;
PD1013 791;
PD1600 2600;
SP0;
`},setup:{grid:`2x3:40x40`}},{name:`engrave`,panel:`engrave`,world:`engraving`,file:{name:`landscape.png`,url:new URL(`landscape.png`,import.meta.url).href}},{name:`pick`,panel:`teach`,world:`cubes`,file:{name:`pick.plan.json`,text:`{
  "format": "magician-plan",
  "version": 1,
  "title": "Pick and place",
  "tool": "suction",
  "steps": [
    { "move": [220, 90, 10, 0], "by": "joints", "name": "above the red cube" },
    { "move": [220, 90, -35, 0], "by": "line", "name": "on the red cube" },
    { "suction": true },
    { "wait": 0.5 },
    { "move": [220, 90, 10, 0], "by": "line", "name": "above the red cube" },
    { "move": [220, -130, 10, 0], "by": "joints", "name": "above the free place" },
    { "move": [220, -130, -35, 0], "by": "line", "name": "on the free place" },
    { "suction": false },
    { "wait": 0.5 },
    { "move": [220, -130, 10, 0], "by": "line", "name": "above the free place" },
    { "move": [220, 0, 60, 0], "by": "joints", "name": "rest" }
  ]
}
`}},{name:`stack`,panel:`teach`,world:`cubes`,file:{name:`stack.plan.json`,text:`{
  "format": "magician-plan",
  "version": 1,
  "title": "Stack of three",
  "tool": "suction",
  "steps": [
    { "move": [250, 40, 10, 0], "by": "joints", "name": "above the green cube" },
    { "move": [250, 40, -35, 0], "by": "line", "name": "on the green cube" },
    { "suction": true },
    { "wait": 0.5 },
    { "move": [250, 40, 10, 0], "by": "line", "name": "above the green cube" },
    { "move": [230, -40, 35, 0], "by": "joints", "name": "above the blue cube" },
    { "move": [230, -40, -10, 0], "by": "line", "name": "on the blue cube" },
    { "suction": false },
    { "wait": 0.5 },
    { "move": [230, -40, 35, 0], "by": "line", "name": "above the blue cube" },
    { "move": [220, 90, 10, 0], "by": "joints", "name": "above the red cube" },
    { "move": [220, 90, -35, 0], "by": "line", "name": "on the red cube" },
    { "suction": true },
    { "wait": 0.5 },
    { "move": [220, 90, 10, 0], "by": "line", "name": "above the red cube" },
    { "move": [230, -40, 60, 0], "by": "joints", "name": "above the green cube" },
    { "move": [230, -40, 15, 0], "by": "line", "name": "on the green cube" },
    { "suction": false },
    { "wait": 0.5 },
    { "move": [230, -40, 60, 0], "by": "line", "name": "above the green cube" },
    { "move": [220, 0, 60, 0], "by": "joints", "name": "rest" }
  ]
}
`}},{name:`belt`,panel:`run`,world:`pick_and_sort`,file:{name:`belt.plan.json`,text:`{
  "format": "magician-plan",
  "version": 1,
  "title": "Unload the belt",
  "tool": "suction",
  "steps": [
    { "move": [220, 0, 60, 0], "by": "joints", "name": "rest" },
    { "command": "EMotor", "values": { "index": 0, "is_enabled": 1, "speed": 7490 } },
    { "wait": 2.4 },
    { "command": "EMotor", "values": { "index": 0, "is_enabled": 0, "speed": 0 } },
    { "move": [260, 0, 35, 0], "by": "joints", "name": "above the red cube" },
    { "move": [260, 0, -10, 0], "by": "line", "name": "on the red cube" },
    { "suction": true },
    { "wait": 0.5 },
    { "move": [260, 0, 35, 0], "by": "line", "name": "above the red cube" },
    { "move": [140, -200, 10, 0], "by": "joints", "name": "above the table" },
    { "move": [140, -200, -50, 0], "by": "line", "name": "on the table" },
    { "suction": false },
    { "wait": 0.5 },
    { "move": [140, -200, 10, 0], "by": "line", "name": "above the table" },
    { "command": "EMotor", "values": { "index": 0, "is_enabled": 1, "speed": 7490 } },
    { "wait": 1.6 },
    { "command": "EMotor", "values": { "index": 0, "is_enabled": 0, "speed": 0 } },
    { "move": [260, 0, 35, 0], "by": "joints", "name": "above the green cube" },
    { "move": [260, 0, -10, 0], "by": "line", "name": "on the green cube" },
    { "suction": true },
    { "wait": 0.5 },
    { "move": [260, 0, 35, 0], "by": "line", "name": "above the green cube" },
    { "move": [170, -200, 10, 0], "by": "joints", "name": "above the table" },
    { "move": [170, -200, -50, 0], "by": "line", "name": "on the table" },
    { "suction": false },
    { "wait": 0.5 },
    { "move": [170, -200, 10, 0], "by": "line", "name": "above the table" },
    { "command": "EMotor", "values": { "index": 0, "is_enabled": 1, "speed": 7490 } },
    { "wait": 1.6 },
    { "command": "EMotor", "values": { "index": 0, "is_enabled": 0, "speed": 0 } },
    { "move": [260, 0, 35, 0], "by": "joints", "name": "above the blue cube" },
    { "move": [260, 0, -10, 0], "by": "line", "name": "on the blue cube" },
    { "suction": true },
    { "wait": 0.5 },
    { "move": [260, 0, 35, 0], "by": "line", "name": "above the blue cube" },
    { "move": [200, -200, 10, 0], "by": "joints", "name": "above the table" },
    { "move": [200, -200, -50, 0], "by": "line", "name": "on the table" },
    { "suction": false },
    { "wait": 0.5 },
    { "move": [200, -200, 10, 0], "by": "line", "name": "above the table" },
    { "move": [220, 0, 60, 0], "by": "joints", "name": "rest" }
  ]
}
`}},{name:`teach`,panel:`teach`,world:`cubes`,file:{name:`points.plan.json`,text:`{
  "format": "magician-plan",
  "version": 1,
  "title": "Four points",
  "steps": [
    { "move": [210, 120, 20, 0], "by": "joints", "name": "left" },
    { "move": [280, 0, 60, 0], "by": "joints", "name": "far" },
    { "move": [210, -120, 20, 0], "by": "joints", "name": "right" },
    { "move": [190, 0, -20, 0], "by": "joints", "name": "near" },
    { "move": [210, 120, 20, 0], "by": "joints", "name": "left again" }
  ]
}
`}},{name:`playback`,panel:`run`,world:`cubes`,file:{name:`boxes.playback`,text:`<root><row_StudioVersion><item_0>Ver-170</item_0></row_StudioVersion><row0><item_0>1</item_0><item_1>Home</item_1><item_2>220.0</item_2><item_3>0.0</item_3><item_4>60.0</item_4><item_5>0.0</item_5><item_10>0.0</item_10><item_12>0</item_12></row0><row1><item_0>0</item_0><item_1>Pick</item_1><item_2>240.0</item_2><item_3>-60.0</item_3><item_4>-20.0</item_4><item_5>0.0</item_5><item_10>0.5</item_10><item_12>1</item_12></row1><row2><item_0>0</item_0><item_1>Place</item_1><item_2>200.0</item_2><item_3>120.0</item_3><item_4>-10.0</item_4><item_5>30.0</item_5><item_10>0.0</item_10><item_12>1</item_12></row2><row3><item_0>2</item_0><item_1 /><item_2>200.0</item_2><item_3>120.0</item_3><item_4>-20.0</item_4><item_5>30.0</item_5><item_10>0.25</item_10><item_12>0</item_12></row3><row4><item_0>1</item_0><item_1>Home2</item_1><item_2>220.0</item_2><item_3>0.0</item_3><item_4>60.0</item_4><item_5>0.0</item_5><item_10>0.0</item_10><item_12>0</item_12></row4></root>`}},{name:`faults`,panel:`run`,world:`faults`,file:{name:`faults.plan.json`,text:`{
  "format": "magician-plan",
  "version": 1,
  "title": "A bad day",
  "steps": [
    { "joints": [0, 20, 30, 0] },
    { "joints": [40, 10, 10, 60] },
    { "joints": [-40, 10, 10, -60] },
    { "joints": [40, 10, 10, 60] },
    { "joints": [-40, 10, 10, -60] },
    { "joints": [40, 10, 10, 60] },
    { "joints": [-40, 10, 10, -60] },
    { "joints": [40, 10, 10, 60] },
    { "joints": [-40, 10, 10, -60] },
    { "joints": [40, 10, 10, 60] },
    { "joints": [-40, 10, 10, -60] },
    { "joints": [40, 10, 10, 60] },
    { "joints": [-40, 10, 10, -60] },
    { "joints": [40, 10, 10, 60] },
    { "joints": [-40, 10, 10, -60] },
    { "joints": [40, 10, 10, 60] },
    { "joints": [-40, 10, 10, -60] },
    { "joints": [0, 45, 45, 0] }
  ]
}
`}}],[T,E]=[3e4,3e3],D=e(()=>r.value===`none`||o.value?.virtual===!0),O=e(()=>{let e=c.value;return r.value===`none`||e===`why.free`?null:e});async function k(){if(r.value===`none`&&a(),!await v(()=>m.value&&_.value!==null,T))throw Error(d(`why.lost`));return r.value!==`sim`&&h.value===`free`&&await p(),await v(()=>h.value===`mine`,E)&&c.value===null}async function A({name:e,text:t,url:n}){return new File([t??await(await fetch(n??``)).blob()],e)}async function j(e,t){if(e.panel!==`draw`&&e.panel!==`engrave`)return await b.select(t),b;let n=y[e.panel===`draw`?`pen`:`laser`];return n.clear(),e.file===void 0?n.write(t):n.take(t),await n.ready,n}var M=e=>u(async()=>{if(!await k())return;let t=o.value?.virtual===!0&&await i(e.world,!1);location.hash=`#/${e.panel}`,await g(e.panel);let n=e.file===void 0?null:await A(e.file);if(e.panel===`teach`&&n!==null){await S(n),t&&await C(`all`);return}let r=n===null?e.text??``:await x(n.name,n),a=await j(e,r);for(let[t,n]of Object.entries(e.setup??{}))a.setValue(t,n);t&&await a.check()&&await a.start(r,()=>``)}),N=f({en:{"gallery.title":`Examples`,"gallery.runs":`Press one: the virtual arm gets the world that it needs, and begins. What it had before is gone.`,"gallery.opens":`Press one: it opens in its panel. A real arm moves only when you press Start there.`,"draw.title":`Draw a picture`,"draw.text":`A rabbit out of a hat, with a pen on paper.`,"write.title":`Write a word`,"write.text":`Type your own instead: it is drawn as large as the sheet.`,"stamp.title":`Six stars`,"stamp.text":`One drawing, repeated in rows and columns.`,"engrave.title":`Engrave a photo`,"engrave.text":`The laser burns a lake between mountains into wood.`,"pick.title":`Pick and place`,"pick.text":`The suction cup carries a cube to another place.`,"stack.title":`Build a tower`,"stack.text":`Three cubes on each other.`,"belt.title":`Unload a belt`,"belt.text":`The belt brings cubes, the arm takes them off.`,"teach.title":`Teach points`,"teach.text":`Four points, played one after the other. Add your own.`,"playback.title":`Play a DobotStudio file`,"playback.text":`A playback with suction and jumps, as DobotStudio saves it.`,"faults.title":`A bad day`,"faults.text":`A joint slips, the cable is pulled, an alarm holds the arm. See what a program does.`},zh:{"gallery.title":`示例`,"gallery.runs":`点一个：虚拟机械臂会换到所需的场景并立即开始。之前的内容将消失。`,"gallery.opens":`点一个：它会在相应页面打开。真实机械臂只有在您按下“开始”后才会移动。`,"draw.title":`画一幅画`,"draw.text":`用笔在纸上画一只从帽子里出来的兔子。`,"write.title":`写一个词`,"write.text":`也可以输入自己的文字：写满整张纸。`,"stamp.title":`六颗星`,"stamp.text":`把一个图形按行和列重复画出。`,"engrave.title":`雕刻照片`,"engrave.text":`激光在木板上烧出群山间的湖。`,"pick.title":`抓取与放置`,"pick.text":`吸盘把一个方块搬到另一处。`,"stack.title":`搭一座塔`,"stack.text":`把三个方块叠起来。`,"belt.title":`从传送带取物`,"belt.text":`传送带送来方块，机械臂把它们取下。`,"teach.title":`示教点`,"teach.text":`四个点依次重放。可以加上自己的点。`,"playback.title":`播放 DobotStudio 文件`,"playback.text":`DobotStudio 保存的回放文件，带吸盘和门形移动。`,"faults.title":`倒霉的一天`,"faults.text":`关节打滑、线缆被拔、报警使机械臂停住。看看程序会怎样。`}});function P({example:e,off:t,opens:r}){let{name:i,panel:a}=e;return n(`li`,{children:n(`button`,{type:`button`,class:`example`,"data-testid":`gallery-${i}`,disabled:t,"aria-describedby":t?`gallery-why`:void 0,onClick:r,children:[n(`img`,{src:`assets/example-${i}.webp`,alt:``,width:`320`,height:`200`,loading:`lazy`}),n(`b`,{children:N(`${i}.title`)}),n(`span`,{class:`hint`,children:N(`${i}.text`)}),n(`small`,{children:d(`nav.${a}`)})]})})}function F(){let e=t(!1),r=O.value,i=async t=>{e.value=!0,await M(t),e.value=!1};return n(s,{title:N(`gallery.title`),class:`gallery-card`,"data-testid":`gallery`,children:[n(`p`,{class:`hint`,children:N(D.value?`gallery.runs`:`gallery.opens`)}),n(l,{id:`gallery-why`,text:r===null?null:d(r)}),n(`ul`,{class:`gallery`,children:w.map(t=>n(P,{example:t,off:r!==null||e.value,opens:()=>void i(t)},t.name))})]})}export{F as Gallery};